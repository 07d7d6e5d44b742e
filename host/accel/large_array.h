// Arrays of many megabytes that are written once from end to end: huge pages save most of their page faults.
#pragma once

#include <stdlib.h>
#include <sys/mman.h>

// Memory for `count` elements (at least one), aligned to 64 bytes or more and not cleared; freed with free(). NULL
// where there is none.
static inline void *large_array(size_t count, size_t element_bytes)
{
  enum { HUGE_PAGE = 2 << 20 };
  if (count == 0) count = 1;
  if (count > (SIZE_MAX - HUGE_PAGE) / element_bytes) return NULL;
  size_t page = count * element_bytes < 2 * HUGE_PAGE ? 64 : HUGE_PAGE;
  size_t bytes = (count * element_bytes + page - 1) / page * page;
  void *memory = aligned_alloc(page, bytes);
#ifdef MADV_HUGEPAGE
  if (memory && page == HUGE_PAGE) madvise(memory, bytes, MADV_HUGEPAGE);  // refused: pages stay small
#endif
  return memory;
}

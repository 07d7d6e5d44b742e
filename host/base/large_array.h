// Arrays of many megabytes that are written once from end to end: huge pages save most of their page faults.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>

enum { HUGE_PAGE = 2 << 20, ARRAY_ALIGNMENT = 64 };

// Is memory of that size worth huge pages?
static inline bool has_huge_pages(size_t bytes) { return bytes >= 2 * HUGE_PAGE; }

// Asks for huge pages in new memory, of any kind and alignment; NULL is none. What is there is kept; a system that has
// none, or refuses, leaves pages small. Returns the memory.
static inline void *huge_pages_ask(void *memory, size_t bytes)
{
#ifdef MADV_HUGEPAGE
  uintptr_t at = (uintptr_t)memory, page = HUGE_PAGE, begin = (at + page - 1) / page * page;
  if (memory && has_huge_pages(bytes)) madvise((void *)begin, (at + bytes) / page * page - begin, MADV_HUGEPAGE);
#endif
  return memory;
}

// Memory for `count` elements (at least one), aligned to ARRAY_ALIGNMENT bytes or more and not cleared; freed with
// free(). NULL where there is none.
static inline void *large_array(size_t count, size_t element_bytes)
{
  if (count == 0) count = 1;
  if (count > (SIZE_MAX - HUGE_PAGE) / element_bytes) return NULL;
  size_t page = has_huge_pages(count * element_bytes) ? HUGE_PAGE : ARRAY_ALIGNMENT;
  size_t bytes = (count * element_bytes + page - 1) / page * page;
  return huge_pages_ask(aligned_alloc(page, bytes), bytes);
}

// What ran when: one span for each kernel launch, transfer and host step. Filled by the program and by host/device,
// printed by host/report.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct Span {
  const char *name;         // a sentence; static storage, spans are summed by it
  double begin_ms, end_ms;  // clock_ms()
  uint64_t items;           // rays, pixels or bytes handled; 0 where it means nothing
  bool on_device;
} Span;

typedef struct Timeline {
  Span *spans;
  size_t count, capacity;
} Timeline;

// Appends a span, from any thread; drops it when out of memory, as a profile is not worth failing for.
void timeline_add(Timeline *timeline, Span span);

// Appends a host span that began at `begin_ms` and ends now.
void timeline_end(Timeline *timeline, const char *name, double begin_ms);

void timeline_free(Timeline *timeline);

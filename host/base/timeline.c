#include "base/timeline.h"

#include <pthread.h>
#include <stdlib.h>

#include "base/clock.h"

static pthread_mutex_t adding = PTHREAD_MUTEX_INITIALIZER;

void timeline_add(Timeline *timeline, Span span)
{
  pthread_mutex_lock(&adding);
  if (timeline->count == timeline->capacity) {
    size_t capacity = timeline->capacity ? 2 * timeline->capacity : 256;
    Span *spans = realloc(timeline->spans, capacity * sizeof *spans);
    if (!spans) goto done;
    timeline->spans = spans;
    timeline->capacity = capacity;
  }
  timeline->spans[timeline->count++] = span;

done:
  pthread_mutex_unlock(&adding);
}

void timeline_end(Timeline *timeline, const char *name, double begin_ms)
{
  timeline_add(timeline, (Span){.name = name, .begin_ms = begin_ms, .end_ms = clock_ms()});
}

void timeline_free(Timeline *timeline)
{
  free(timeline->spans);
  *timeline = (Timeline){0};
}

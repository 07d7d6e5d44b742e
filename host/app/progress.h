// How far a run is, on standard error.
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct Progress {
  bool wanted, quiet;  // --progress, --quiet
  double begin_ms;     // clock_ms() of the run
  uint64_t done, pictures;
  double drawn_ms;  // when the line was last drawn
  int tenths;       // said last, where there is no terminal; -1 at first
  bool shown;
} Progress;

// The function that render/frame.h calls with the share done of one picture, its context a Progress; NULL where nothing
// is to be said.
typedef void (*ProgressSay)(void *progress, double share);
ProgressSay progress_choose(const Progress *progress);

// Removes the line.
void progress_end(const Progress *progress);

// Frames of a sequence: which ones, and where their pictures go.
#pragma once

#include <stdint.h>

#include "app/command_line.h"

// Frames first, first + step, ... up to last; with `all` up to the end of the animation. Not `given`: one picture of
// the pose at rest.
typedef struct FrameRange {
  bool given, all;
  uint32_t first, last, step;
} FrameRange;

// "12", "0-47", "0-47x2" or "all".
Status option_read_frames(void *field, const Option *option, const char *text, Log *log);

// The last frame of a sequence that is length_s long, the one at its end.
uint32_t frames_last(double length_s, double fps);

enum { FRAMES_MOST = 1000000 };
uint64_t frames_count(const FrameRange *range);

// Does a path name the frame, as `{frame}` or, with zeros before it, `{frame:04}`?
bool path_names_frame(const char *path);

// A path with the frame's number in all these places, freed by the caller; NULL for NULL. `{{` is a brace. Errors:
// STATUS_USAGE (what else stands in braces), STATUS_NO_MEMORY.
Status path_of_frame(char **out, const char *path, uint32_t frame, Log *log);

// Mirrors that the camera sees in other mirrors.
#pragma once

#include "render/mirrors_seen.h"

// Counts, in within[object], the rays that mirrors reflect as the second in a row, where the rays of a wave began. Of
// what such a ray brings less than 1/255 may be seen: then the shader sends none. `picture` is what the wave is of, its
// rays are frame->streams[0], and their hits frame->hits, which are lost; slots are the identity.
// Cost: a ray a pixel of mirrors, and shading twice without lights. Errors: those of rendering; STATUS_NO_MEMORY.
Status mirrors_within_see(Reflector *within, Frame *frame, const uint32_t *starts, const Wave *wave,
                          const CameraInfo *picture, Log *log);

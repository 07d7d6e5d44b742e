// Renders a picture that is captured, wave by wave, with the frame's own streams and shader.
#pragma once

#include "render/frame.h"

// Keeps a wave's radiance, of which each sample counts `share`.
typedef Status (*WaveKeep)(Frame *frame, const Wave *wave, float share, Log *log);

// The frame's camera becomes one of width x height pixels, multiples of TILE_SIZE.
Status capture_waves(Frame *frame, uint32_t width, uint32_t height, uint32_t samples, WaveKeep keep, Log *log);

// Tiles [first_tile, first_tile + tiles) of it alone.
Status capture_some_waves(Frame *frame, uint32_t width, uint32_t height, uint32_t first_tile, uint32_t tiles,
                          uint32_t samples, WaveKeep keep, Log *log);

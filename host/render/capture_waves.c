#include "render/capture_waves.h"

#include "shared/stream.h"

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

Status capture_some_waves(Frame *frame, uint32_t width, uint32_t height, uint32_t first_tile, uint32_t tiles,
                          uint32_t samples, WaveKeep keep, Log *log)
{
  Status status = STATUS_OK;
  CameraInfo *picture = &frame->camera.info;
  picture->width = width;
  picture->height = height;
  picture->crop_x = picture->crop_y = 0;
  picture->tiles_per_row = width / TILE_SIZE;
  uint32_t wave_tiles = frame_wave_tiles(frame, tiles, 1);
  uint32_t wave_samples = smaller(samples, frame->capacity / (wave_tiles * TILE_PIXELS));
  for (uint32_t sample = 0; sample < samples; sample += wave_samples)
    for (uint32_t tile = 0; tile < tiles; tile += wave_tiles) {
      Wave wave = {first_tile + tile, smaller(wave_tiles, tiles - tile), sample,
                   smaller(wave_samples, samples - sample)};
      TRY(frame_render_wave(frame, &wave, log));
      TRY(keep(frame, &wave, 1.0f / (float)samples, log));
    }

done:
  return status;
}

Status capture_waves(Frame *frame, uint32_t width, uint32_t height, uint32_t samples, WaveKeep keep, Log *log)
{
  const uint32_t tiles = width / TILE_SIZE * (height / TILE_SIZE);
  return capture_some_waves(frame, width, height, 0, tiles, samples, keep, log);
}

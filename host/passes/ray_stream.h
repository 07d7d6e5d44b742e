// Ray and hit streams on the device; layout in shared/stream.h.
#pragma once

#include "device/device.h"

typedef struct RayStream {
  DeviceBuffer rays;   // [fields][capacity] floats
  DeviceBuffer slots;  // [capacity]
  uint32_t capacity;   // a multiple of 64
} RayStream;

// Copies the first fields of rays [0, count), one after the other: fields[field * count + ray]. Waits for the device.
Status ray_stream_read(float *fields, Device *device, const RayStream *stream, uint32_t field_count, uint32_t count,
                       Log *log);

typedef struct HitStream {
  DeviceBuffer hits;  // [HIT_FIELD_COUNT][capacity] floats
  DeviceBuffer ids;   // [capacity]
} HitStream;

// `segments` streams of `capacity` rays behind each other (one a light, for shadow rays), of RAY_FIELD_COUNT fields.
Status ray_stream_make(RayStream *out, Device *device, uint32_t capacity, uint32_t segments, const char *what,
                       Log *log);
void ray_stream_free(RayStream *stream);
Status hit_stream_make(HitStream *out, Device *device, uint32_t capacity, Log *log);
void hit_stream_free(HitStream *stream);

// What reflects in a small picture, read back: the ray, and what it meets.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/math3d.h"
#include "passes/ray_stream.h"

typedef struct ReflectionSight {
  bool is_reflected;  // by a mirror, once
  uint32_t triangle;  // that reflects
  Vec3 origin, direction;
  double distance;  // of what it meets, in lengths of the direction; INFINITY
  uint32_t met;     // triangle; HIT_NONE
  bool is_lobe;     // a sample of a rough surface's lobe, or a ray about which maps are asked for one
  float density;    // of the sample, 1 / sr
  float roughness;  // of the surface of which maps are asked
  float weight[3];  // throughput
  float direct[4];  // radiance before anything that is reflected
  float radiance[4];
} ReflectionSight;

// By slot of one wave that holds all of the picture. With `axes` maps are asked, those of rough surfaces' lobes; rays
// are then kept before.
typedef struct ReflectionSights {
  ReflectionSight *sights;  // [capacity]
  uint32_t capacity;
  bool axes;
} ReflectionSights;

Status reflection_sights_make(ReflectionSights *out, uint32_t capacity, Log *log);
void reflection_sights_free(ReflectionSights *sights);

// Keeps rays [0, count), traced unless `hits` is NULL, and the radiance so far. Waits for the device.
Status reflection_sights_keep(ReflectionSights *sights, Device *device, const RayStream *rays, uint32_t count,
                              const HitStream *hits, const DeviceBuffer *radiance, Log *log);

// Keeps the wave's radiance, for slots [0, count).
Status reflection_sights_light(ReflectionSights *sights, Device *device, const DeviceBuffer *radiance, uint32_t count,
                               Log *log);

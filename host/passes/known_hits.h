// Rays of which maps know what they hit, so that they need not be traced: cl/rays/append_hits.cl.
#pragma once

#include "device/device.h"
#include "passes/ray_stream.h"

typedef struct KnownHits {
  Kernel append;
  RayStream rays;
  HitStream hits;
} KnownHits;

// For waves of up to `capacity` rays; without `wanted` the streams stand for ones that nothing is written to.
Status known_hits_make(KnownHits *out, Device *device, uint32_t capacity, bool wanted, Log *log);
void known_hits_free(KnownHits *known);

// Rays that a method leaves to others.
typedef struct LeftRays {
  uint32_t traced;  // to be traced
  uint32_t known;   // to be shaded alone
} LeftRays;

// Puts known rays and their hits behind the first `traced` of a stream.
Status known_hits_append(const KnownHits *known, Device *device, const LeftRays *left, const RayStream *rays,
                         const HitStream *hits, Log *log);

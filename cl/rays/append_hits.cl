// Puts rays whose hits are known behind those of a stream that have been traced, so that one launch shades both.
//
//   in    from_rays, from_slots, from_hits, from_ids   [0, ray_count), of streams of `capacity`
//   out   rays, slots, hits, ids                       from `first` on, of the same capacity
//
//   Cost  60 bytes read and written a ray.

#include "lib/lanes.cl"
#include "shared/stream.h"

kernel void append_hits(uint ray_count, uint first, uint capacity, global const float *from_rays,
                        global const uint *from_slots, global const float *from_hits, global const uint *from_ids,
                        global float *rays, global uint *slots, global float *hits, global uint *ids)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint i = begin; i < end; i++) {
    for (uint field = 0; field < RAY_FIELD_COUNT; field++)
      rays[field * capacity + first + i] = from_rays[field * capacity + i];
    for (uint field = 0; field < HIT_FIELD_COUNT; field++)
      hits[field * capacity + first + i] = from_hits[field * capacity + i];
    slots[first + i] = from_slots[i];
    ids[first + i] = from_ids[i];
  }
}

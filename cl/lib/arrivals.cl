// Rays that arrive at shading: what they hit, and where what they see goes.

#include "lib/camera_ray.cl"
#include "lib/radiance.cl"
#include "lib/ray_stream.cl"
#include "lib/triangle.cl"  // under no condition, as a file is included once
#include "shared/scene.h"
#include "shared/shade.h"
#ifdef HAS_KEYS
#include "lib/key_hit.cl"
#endif

// As the kernel's parameters.
typedef struct ArrivalSources {
  global const float *rays;
  global const uint *slots;
  global const float *hits;
  global const uint *hit_ids;
  global ulong *keys;
  uint capacity;
  global const TriangleCorners *corners;
  global const float *positions;
} ArrivalSources;

// LANES of them. The origin is that of camera rays.
typedef struct Arrivals {
  UintL slot, id;  // id: of the triangle; HIT_NONE
  Vec3L origin, direction, weight;
  FloatL t_max;  // below 0: inactive
#ifdef HAS_KEYS
  ulong key;
#endif
} Arrivals;

static inline Arrivals arrivals_load(const ArrivalSources *from, const ShadeInfo *shade, const WaveTile *tile,
                                     uint first, uint ray_count)
{
  Arrivals out;
#ifdef HAS_KEYS
  out.key = shade->from_keys ? key_take(from->keys, first) : from->hit_ids[first];
  out.id = (uint)out.key;
#else
  out.id = LANE_LOAD(from->hit_ids, first);
#endif
  if (shade->from_camera) {
    FloatL one = FLOATL(1);
    out.slot = UINTL(first) + LANE_AS_UINT(INTL(0) + LANE_INDEX);
    CameraRay ray = wave_ray(&out.t_max, tile, first);
    out.origin = ray.origin;
    out.direction = ray.direction;
    out.weight = vec3l(one, one, one);
    return out;
  }
  out.slot = LANE_LOAD(from->slots, first);
  out.direction = stream_load3(from->rays, from->capacity, RAY_DIRECTION_X, first);
  out.weight = stream_load3(from->rays, from->capacity, RAY_WEIGHT_R, first);
  out.t_max = stream_load_t_max(from->rays, from->capacity, first, ray_count);
  return out;
}

static inline HitPlace arrival_place(const Arrivals *in, const ArrivalSources *from, const ShadeInfo *shade,
                                     const WaveTile *tile, uint first)
{
#ifdef HAS_KEYS
  if (shade->from_keys) {
    CameraRay ray = {in->origin, in->direction};
    return key_hit(in->key, &ray, tile->view.camera, from->corners, from->positions);
  }
#endif
  return hit_place_load(from->hits, from->capacity, first);
}

// Asks for the corners of triangles that are shaded soon.
static inline void corners_prefetch(global const TriangleCorners *corners, global const uint *hit_ids, uint first,
                                    uint ray_count)
{
#ifdef HAS_PREFETCH
  if (first >= ray_count) return;
  UintL id = LANE_LOAD(hit_ids, first);
  if (!any_lane(id != UINTL(id.s0))) {  // many show one triangle, or none
    if (id.s0 != HIT_NONE) PREFETCH(corners + id.s0);
    return;
  }
#pragma unroll
  for (uint lane = 0; lane < LANES; lane++) PREFETCH(corners + LANE_UINT(id, lane));
#endif
}

// Keeps what neighbouring slots see. On a GPU by one store for both places: two take registers.
static inline void sum_keep(global float4 *radiance, const ShadeInfo *shade, const WaveTile *tile, uint first,
                            UintL slot, IntL mask, const Sum *sum)
{
  UintL x, y;
  const bool to_picture = shade->to_picture != SHADE_TO_SLOTS, adds = shade->to_picture == SHADE_TO_PICTURE;
  constant CameraInfo *camera = tile->view.camera;
  tile_pixels(&x, &y, &tile->view, first % TILE_PIXELS);
#if LANES == 1
  uint place = to_picture ? y * camera->width + x : slot;
  if (to_picture) mask = x < camera->width && y < camera->height;
  if (mask) radiance[place] = adds ? radiance[place] + sum_of_lane(*sum, 0) : sum_of_lane(*sum, 0);
#else
  if (to_picture)
    picture_store(radiance, camera->width, camera->height, x, y, adds, *sum);
  else
    radiance_store(radiance, slot, mask, *sum);
#endif
}

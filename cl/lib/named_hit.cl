// A ray's hit on one of a few triangles that a map names, with the bits that trace_closest gives.

#include "lib/hit.cl"
#include "shared/stream.h"

// Nearest hit; the id is HIT_NONE where there is none.
typedef struct NamedHit {
  float t, u, v;
  uint id;
} NamedHit;

// Axes are permuted as those of the sheared ray.
typedef struct NamedRay {
  ShearedRay sheared;
  SlabAxis slab[3];
  uint kz;
  bool positive_kz;
} NamedRay;

static inline float3 permuted(float3 v, uint kz) { return kz == 0 ? v.yzx : kz == 1 ? v.zxy : v; }

static inline NamedRay named_ray(float3 origin, float3 direction)
{
  NamedRay ray;
  float3 size = fabs(direction);
  ray.kz = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  ray.sheared = shear_ray(vec3l(FLOATL(origin.x), FLOATL(origin.y), FLOATL(origin.z)),
                          vec3l(FLOATL(direction.x), FLOATL(direction.y), FLOATL(direction.z)), ray.kz);
  float3 from = permuted(origin, ray.kz), along = permuted(direction, ray.kz);
  ray.positive_kz = along.z > 0;
  ray.slab[0] = slab_axis(FLOATL(from.x), FLOATL(along.x));
  ray.slab[1] = slab_axis(FLOATL(from.y), FLOATL(along.y));
  ray.slab[2] = slab_axis(FLOATL(from.z), FLOATL(along.z));
  return ray;
}

// Up to LANES triangles, permuted as the ray is. By bit: those open from behind, and those of which more than the plane
// would have to be asked, as alpha.
typedef struct NamedTriangles {
  FloatL vertex[3][3];
  uint ids[LANES];
  uint count, single_sided, unclear;
} NamedTriangles;

static inline NamedTriangles named_none(void)
{
  NamedTriangles none;
  for (uint c = 0; c < 3; c++)
    for (uint axis = 0; axis < 3; axis++) none.vertex[c][axis] = FLOATL(0);
  none.count = none.single_sided = none.unclear = 0;
  return none;
}

static inline void named_add(NamedTriangles *to, const NamedRay *ray, float3 a, float3 b, float3 c, uint id,
                             bool single_sided, bool unclear)
{
  const float3 corners[3] = {a, b, c};
  uint k = to->count++;
  for (uint i = 0; i < 3; i++) {
    float3 at = permuted(corners[i], ray->kz);
    LANE_FLOAT(to->vertex[i][0], k) = at.x;
    LANE_FLOAT(to->vertex[i][1], k) = at.y;
    LANE_FLOAT(to->vertex[i][2], k) = at.z;
  }
  to->ids[k] = id;
  to->single_sided |= single_sided ? 1u << k : 0;
  to->unclear |= unclear ? 1u << k : 0;
}

// Makes *nearest that of the triangles, if it is nearer. *unclear_t is made that of the nearest of those that are not
// clear, likewise.
static inline void named_test(NamedHit *nearest, float *unclear_t, const NamedRay *ray, const NamedTriangles *of)
{
  FloatL zero = FLOATL(0);
  TriangleHit hit =
      triangle_intersect(&ray->sheared, of->vertex[0][0], of->vertex[0][1], of->vertex[0][2], of->vertex[1][0],
                         of->vertex[1][1], of->vertex[1][2], of->vertex[2][0], of->vertex[2][1], of->vertex[2][2]);
  IntL there = hit.inside & (hit.t > zero);
  if (any_lane(there & hit.doubtful)) {
    hit_hold(&hit, zero, ray->slab, of->vertex[0], of->vertex[1], of->vertex[2]);
    there = there & hit.inside;
  }
  uint bits = lane_bits(there & (hit.t > hit.t_error)) & ((1u << of->count) - 1);
  for (; bits; bits &= bits - 1) {
    uint k = lowest_bit(bits), id = of->ids[k];
    float t = LANE_FLOAT(hit.t, k);
    bool back = (LANE_INT(hit.determinant_positive, k) != 0) != ray->positive_kz;
    if (back && (of->single_sided >> k & 1)) continue;
    if (of->unclear >> k & 1) {
      *unclear_t = min(*unclear_t, t);
    } else if (t < nearest->t || (t == nearest->t && id < nearest->id)) {
      NamedHit found = {t, LANE_FLOAT(hit.u, k), LANE_FLOAT(hit.v, k), id};
      *nearest = found;
    }
  }
}

// Adds ray `index` of a stream of mirrors' rays to another. Returns its place there.
static inline uint ray_append(global const float *rays, global const uint *slots, uint capacity, uint index,
                              global float *to_rays, global uint *to_slots, global uint *count)
{
  uint at = atomic_inc(count);
  for (uint field = 0; field < RAY_DENSITY; field++) to_rays[field * capacity + at] = rays[field * capacity + index];
  to_rays[RAY_DENSITY * capacity + at] = INFINITY;
  to_slots[at] = slots[index];
  return at;
}

// The same with its hit.
static inline void named_append(const NamedHit *hit, global const float *rays, global const uint *slots, uint capacity,
                                uint index, global float *to_rays, global uint *to_slots, global float *to_hits,
                                global uint *to_ids, global uint *count)
{
  uint at = ray_append(rays, slots, capacity, index, to_rays, to_slots, count);
  to_hits[HIT_T * capacity + at] = hit->t;
  to_hits[HIT_U * capacity + at] = hit->u;
  to_hits[HIT_V * capacity + at] = hit->v;
  to_ids[at] = hit->id;
}

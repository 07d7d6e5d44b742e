// A ray's hit on one of a few triangles that a map names, with the bits that trace_closest gives.

#include "lib/triangle.cl"
#include "shared/cube.h"
#include "shared/scene.h"
#include "shared/stream.h"

#define NAMED_MOST 16

// Nearest hit; the id is HIT_NONE where there is none, or where more than the triangle's plane would have to be asked:
// distances in doubt, alpha.
typedef struct NamedHit {
  float t, u, v;
  uint id;
} NamedHit;

typedef struct NamedTriangles {
  global const float *positions;  // [vertex_count][3]
  global const TriangleCorners *corners;
  global const MaterialInfo *materials;
} NamedTriangles;

static inline NamedHit named_hit(const uint names[NAMED_MOST], const NamedTriangles *from, float3 origin,
                                 float3 direction)
{
  NamedHit nearest = {INFINITY, 0, 0, HIT_NONE};
  float3 size = fabs(direction);
  uint kz = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  ShearedRay ray = shear_ray(vec3l(FLOATL(origin.x), FLOATL(origin.y), FLOATL(origin.z)),
                             vec3l(FLOATL(direction.x), FLOATL(direction.y), FLOATL(direction.z)), kz);
  bool positive_kz = (kz == 0 ? direction.x : kz == 1 ? direction.y : direction.z) > 0;
  for (uint first = 0; first < NAMED_MOST; first += LANES) {
    FloatL vertex[3][3];
    uint flags[NAMED_MOST] = {0}, count = min((uint)LANES, NAMED_MOST - first), wanted = 0;
    for (uint c = 0; c < 3; c++)
      for (uint axis = 0; axis < 3; axis++) vertex[c][axis] = FLOATL(0);
    for (uint k = 0; k < count; k++) {
      uint id = names[first + k];
      if (id == CUBE_NAMELESS || (first + k > 0 && id == names[first + k - 1])) continue;
      TriangleCorners corners = from->corners[id];
      flags[k] = from->materials[corners.material].flags;
      if (flags[k] & (MATERIAL_MASKED | MATERIAL_BLENDED)) continue;
      wanted |= 1u << k;
      for (uint c = 0; c < 3; c++) {
        float3 at = vload3(corners.vertex[c], from->positions);
        LANE_FLOAT(vertex[c][0], k) = kz == 0 ? at.y : kz == 1 ? at.z : at.x;
        LANE_FLOAT(vertex[c][1], k) = kz == 0 ? at.z : kz == 1 ? at.x : at.y;
        LANE_FLOAT(vertex[c][2], k) = kz == 0 ? at.x : kz == 1 ? at.y : at.z;
      }
    }
    if (!wanted) continue;
    TriangleHit hit = triangle_intersect(&ray, vertex[0][0], vertex[0][1], vertex[0][2], vertex[1][0], vertex[1][1],
                                         vertex[1][2], vertex[2][0], vertex[2][1], vertex[2][2]);
    wanted &= lane_bits(hit.inside & !hit.doubtful & (hit.t > hit.t_error));
    for (; wanted; wanted &= wanted - 1) {
      uint k = lowest_bit(wanted), id = names[first + k];
      float t = LANE_FLOAT(hit.t, k);
      bool back = (LANE_INT(hit.determinant_positive, k) != 0) != positive_kz;
      if ((back && (flags[k] & MATERIAL_SINGLE_SIDED)) || !(t < nearest.t || (t == nearest.t && id < nearest.id)))
        continue;
      NamedHit found = {t, LANE_FLOAT(hit.u, k), LANE_FLOAT(hit.v, k), id};
      nearest = found;
    }
  }
  return nearest;
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

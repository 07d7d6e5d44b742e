// The hit that a slot's key stands for: bits of t, then the triangle's id (lib/sample_key.cl). Its weights are those of
// the function that rays use. LANES is 1.

#include "lib/camera_ray.cl"
#include "lib/ray_stream.cl"
#include "lib/triangle.cl"

typedef struct Triangle {
  float3 corner[3];  // world space
  uint id, flags;
} Triangle;

// A triangle as triangle_intersect takes it: from the ray's start, components kx, ky and kz. Neighbours' rays see the
// same, so that it is turned once for many.
typedef struct TurnedTriangle {
  float3 a, b, c;
  uint kz;
} TurnedTriangle;

#define KZ_NONE 3u  // not turned yet

static inline void triangle_turn(TurnedTriangle *out, const Triangle *t, Vec3L from, uint kz)
{
  float3 origin = (float3)(from.x, from.y, from.z);
  float3 a = t->corner[0] - origin, b = t->corner[1] - origin, c = t->corner[2] - origin;
  out->a = kz == 0 ? a.yzx : kz == 1 ? a.zxy : a;
  out->b = kz == 0 ? b.yzx : kz == 1 ? b.zxy : b;
  out->c = kz == 0 ? c.yzx : kz == 1 ? c.zxy : c;
  out->kz = kz;
}

// The edge functions of a triangle at the ray of a sample.
static inline TriangleEdges sample_edge_functions(ShearedRay *sheared, const CameraRay *ray,
                                                  constant CameraInfo *camera, const Triangle *t,
                                                  TurnedTriangle *turned)
{
  uint kz = dominant_axis(ray->direction);
  if (turned->kz != kz || camera->orthographic) triangle_turn(turned, t, ray->origin, kz);
  float3 a = turned->a, b = turned->b, c = turned->c;
  *sheared = shear_ray(vec3l(0, 0, 0), ray->direction, kz);
  return triangle_edges(sheared, a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z);
}

// Of a key that is not all ones, at the ray of its slot.
static inline HitPlace key_hit(ulong key, const CameraRay *ray, constant CameraInfo *camera,
                               global const TriangleCorners *corners, global const float *positions)
{
  ShearedRay sheared;
  Triangle triangle;
  TurnedTriangle turned = {.kz = KZ_NONE};
  global const uint *vertex = corners[(uint)key].vertex;
  for (uint i = 0; i < 3; i++) triangle.corner[i] = vload3(vertex[i], positions);
  TriangleEdges edges = sample_edge_functions(&sheared, ray, camera, &triangle, &turned);
  HitPlace hit = {as_float((uint)(key >> 32)), edges.v / edges.determinant, edges.w / edges.determinant};
  return hit;
}

// A slot's key, which is left as raster finds it next.
static inline ulong key_take(global ulong *keys, uint slot)
{
  ulong key = keys[slot];
  if (key != ULONG_MAX) keys[slot] = ULONG_MAX;
  return key;
}

// LANES rays against the binary BVH, or against one triangle of it.
//
// A packet is split by octant and dominant axis of its directions (nearly always one group), so that the near and far
// planes of a box and the axes of the triangle test are scalars.
//
//   From  Wald, Slusallek, Benthin, Wagner, "Interactive Rendering with Coherent Ray Tracing", 2001; Aila, Laine,
//         "Understanding the Efficiency of Ray Traversal on GPUs", 2009; Ize, "Robust BVH Ray Traversal", JCGT 2013.

#include "lib/hit.cl"
#include "lib/ray_stream.cl"
#include "lib/slab.cl"

#define STACK_SIZE 64  // above BVH_MAX_DEPTH of host/accel

typedef struct Packet {
  Vec3L origin, direction;
  SlabAxis slab[3];
  FloatL t_min, t_max;
  FloatL t, u, v;  // closest hit so far; t starts as t_max
  UintL id;
  IntL occluded;
  IntL absorption;  // of BLEND surfaces met (lib/alpha.cl)
} Packet;

// Distance at which each lane enters the box of child `c`; `*enters` tells whether it does before `limit`.
static inline FloatL box_enter(global const Bvh2Node *node, uint c, const Packet *p, uint octant, FloatL limit,
                               IntL *enters)
{
  uint sx = octant & 1, sy = octant >> 1 & 1, sz = octant >> 2;
#if LANES == 1
  float low_x = node->bounds[c][0][0], high_x = node->bounds[c][0][1];
  float low_y = node->bounds[c][1][0], high_y = node->bounds[c][1][1];
  float low_z = node->bounds[c][2][0], high_z = node->bounds[c][2][1];
  float near_x = sx ? high_x : low_x, far_x = sx ? low_x : high_x;
  float near_y = sy ? high_y : low_y, far_y = sy ? low_y : high_y;
  float near_z = sz ? high_z : low_z, far_z = sz ? low_z : high_z;
#else
  float near_x = node->bounds[c][0][sx], far_x = node->bounds[c][0][1 - sx];
  float near_y = node->bounds[c][1][sy], far_y = node->bounds[c][1][1 - sy];
  float near_z = node->bounds[c][2][sz], far_z = node->bounds[c][2][1 - sz];
#endif
  FloatL enter = max_lane(slab_near(&p->slab[0], FLOATL(near_x)), p->t_min);
  enter = max_lane(slab_near(&p->slab[1], FLOATL(near_y)), enter);
  enter = max_lane(slab_near(&p->slab[2], FLOATL(near_z)), enter);
  FloatL leave = min_lane(slab_far(&p->slab[0], FLOATL(far_x)), limit);
  leave = min_lane(slab_far(&p->slab[1], FLOATL(far_y)), leave);
  leave = min_lane(slab_far(&p->slab[2], FLOATL(far_z)), leave);
  *enters = enter <= leave * FLOATL(BOX_PADDING);
  return enter;
}

static inline TriangleEdges packet_edges(global const BvhTriangle *triangle, const ShearedRay *ray, uint kz)
{
#if LANES == 1
  float4 first = vload4(0, &triangle->vertex[0][0]);
  float4 second = vload4(1, &triangle->vertex[0][0]);
  float third = triangle->vertex[2][2];
  float3 a = first.xyz, b = (float3)(first.w, second.x, second.y), c = (float3)(second.z, second.w, third);
  if (kz == 0) a = a.yzx, b = b.yzx, c = c.yzx;
  if (kz == 1) a = a.zxy, b = b.zxy, c = c.zxy;
  return triangle_edges(ray, a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z);
#else
  uint kx = kz == 2 ? 0 : kz + 1, ky = kz == 0 ? 2 : kz - 1;
  global const float *a = triangle->vertex[0], *b = triangle->vertex[1], *c = triangle->vertex[2];
  return triangle_edges(ray, FLOATL(a[kx]), FLOATL(a[ky]), FLOATL(a[kz]), FLOATL(b[kx]), FLOATL(b[ky]), FLOATL(b[kz]),
                        FLOATL(c[kx]), FLOATL(c[ky]), FLOATL(c[kz]));
#endif
}

static inline void packet_hold(TriangleHit *hit, const Packet *p, global const BvhTriangle *triangle)
{
  const SlabAxis slab[3] = {slab_axis(p->origin.x, p->direction.x), slab_axis(p->origin.y, p->direction.y),
                            slab_axis(p->origin.z, p->direction.z)};
  FloatL vertex[3][3];
  for (uint corner = 0; corner < 3; corner++)
    for (uint axis = 0; axis < 3; axis++) vertex[corner][axis] = FLOATL(triangle->vertex[corner][axis]);
  hit_hold(hit, p->t_min, slab, vertex[0], vertex[1], vertex[2]);
}

// Lanes of `group` for which the hit matters.
static inline IntL packet_accept(const Packet *p, const TriangleHit *hit, IntL group, uint id, uint flags,
                                 IntL positive_kz, bool any_hit, bool culls)
{
  if (!any_hit) return hit_is_closest(hit, group, p->t_min, p->t, p->id, id, flags, positive_kz);
  IntL accept = hit->inside & group & (hit->t > p->t_min) & (hit->t < p->t_max) & !p->occluded;
  return culls ? accept & !hit_is_open(hit, flags, positive_kz) : accept;
}

// What `hit` on a triangle means for the lanes of `group`.
static inline void packet_meet(Packet *p, TriangleHit *hit, IntL group, IntL positive_kz,
                               global const BvhTriangle *triangle, bool any_hit, bool culls,
                               const AttributeSources *attributes)
{
  uint id = triangle->id, flags = triangle->flags;
  IntL accept = packet_accept(p, hit, group, id, flags, positive_kz, any_hit, culls);
  if (!any_lane(accept)) return;
  if (any_lane(accept & hit->doubtful)) {
    packet_hold(hit, p, triangle);
    accept = packet_accept(p, hit, group, id, flags, positive_kz, any_hit, culls);
  }
  accept = hit_counts(hit, accept, id, flags, attributes);
  if (any_hit) {
    accept = accept & hit_before_end(hit, p->t_max);
#ifdef HAS_BLEND
    if (flags & TRIANGLE_BLENDED) {
      p->absorption += alpha_absorption(attributes, id, accept, hit->u, hit->v);
      accept = p->absorption >= INTL(ABSORPTION_ALL);
    }
#endif
    p->occluded = p->occluded | accept;
  } else {
    p->t = accept ? hit->t : p->t;
    p->u = accept ? hit->u : p->u;
    p->v = accept ? hit->v : p->v;
    p->id = accept ? UINTL(id) : p->id;
  }
}

// Tests the triangles of a leaf against the lanes of `group`.
static inline void packet_leaf(Packet *p, IntL group, const ShearedRay *ray, uint kz, IntL positive_kz,
                               global const BvhTriangle *triangles, uint first, uint count, bool any_hit, bool culls,
                               const AttributeSources *attributes)
{
  for (uint i = first; i < first + count; i++) {
    if (any_hit && !culls && is_shadowless(triangles[i].flags)) continue;
    TriangleEdges edges = packet_edges(&triangles[i], ray, kz);
    TriangleHit hit = triangle_hit(&edges, ray);
    packet_meet(p, &hit, group, positive_kz, &triangles[i], any_hit, culls, attributes);
  }
}

// How far each lane still looks: nowhere for lanes outside the group.
static inline FloatL packet_limit(const Packet *p, IntL group, bool any_hit)
{
  return group ? (any_hit ? (p->occluded ? FLOATL(-1) : p->t_max) : p->t) : FLOATL(-1);
}

// Walks the tree with the lanes of `group`, which share `octant` (bit per axis: negative direction) and `kz`.
static inline void packet_walk(Packet *p, IntL group, uint octant, uint kz, global const Bvh2Node *nodes,
                               global const BvhTriangle *triangles, bool any_hit, bool culls,
                               const AttributeSources *attributes)
{
  ShearedRay ray = shear_ray(p->origin, p->direction, kz);
  IntL positive_kz = component3(p->direction, kz) > FLOATL(0);
  uint stack_reference[STACK_SIZE], stack_count[STACK_SIZE];
  FloatL stack_enter[STACK_SIZE];
  uint top = 0, reference = 0, count = 0;
  FloatL limit = packet_limit(p, group, any_hit);
  for (;;) {
    if (count == 0) {
      global const Bvh2Node *node = &nodes[reference];
      IntL enters0, enters1;
      FloatL enter0 = box_enter(node, 0, p, octant, limit, &enters0);
      FloatL enter1 = box_enter(node, 1, p, octant, limit, &enters1);
      bool any0 = any_lane(enters0), any1 = any_lane(enters1);
      if (any0 | any1) {
        uint near = any0 ? 0 : 1;
        if (any0 & any1) {
          uint both = lane_bits(enters0 & enters1);
          near = both ? 2 * popcount(lane_bits(enter1 < enter0) & both) > popcount(both) : 0;
          stack_reference[top] = node->child[1 - near];
          stack_count[top] = node->count[1 - near];
          stack_enter[top] = near ? (enters0 ? enter0 : FLOATL(INFINITY)) : (enters1 ? enter1 : FLOATL(INFINITY));
          top++;
        }
        reference = node->child[near];
        count = node->count[near];
        continue;
      }
    } else {
      packet_leaf(p, group, &ray, kz, positive_kz, triangles, reference & ~BVH_LEAF, count, any_hit, culls, attributes);
      if (any_hit && !any_lane(group & !p->occluded)) return;
      limit = packet_limit(p, group, any_hit);
    }
    do {
      if (top == 0) return;
      top--;
    } while (!any_lane(stack_enter[top] <= limit * FLOATL(BOX_PADDING)));
    reference = stack_reference[top];
    count = stack_count[top];
  }
}

// To be tested against single triangles; to be traced it needs its slabs.
static inline Packet packet_make(Vec3L origin, Vec3L direction, float t_min, FloatL t_max)
{
  Packet p;
  p.origin = origin;
  p.direction = direction;
  p.t_min = FLOATL(t_min);
  p.t_max = t_max;
  p.t = p.t_max;
  p.u = p.v = FLOATL(0);
  p.id = UINTL(HIT_NONE);
  p.occluded = INTL(0);
  p.absorption = INTL(0);
  return p;
}

static inline Packet packet_load(global const float *rays, uint capacity, uint first, uint ray_count, float t_min)
{
  Packet p = packet_make(stream_load3(rays, capacity, RAY_ORIGIN_X, first),
                         stream_load3(rays, capacity, RAY_DIRECTION_X, first), t_min,
                         stream_load_t_max(rays, capacity, first, ray_count));
  p.slab[0] = slab_axis(p.origin.x, p.direction.x);
  p.slab[1] = slab_axis(p.origin.y, p.direction.y);
  p.slab[2] = slab_axis(p.origin.z, p.direction.z);
  return p;
}

// Traces the lanes of `waiting`.
static inline void packet_trace_lanes(Packet *p, IntL waiting, global const Bvh2Node *nodes,
                                      global const BvhTriangle *triangles, bool any_hit, bool culls,
                                      const AttributeSources *attributes)
{
  // The sign of the inverse, not of the direction: that of -0 counts.
  FloatL zero = FLOATL(0);
  UintL octant =
      LANE_AS_UINT((p->slab[0].inverse < zero ? INTL(1) : INTL(0)) | (p->slab[1].inverse < zero ? INTL(2) : INTL(0)) |
                   (p->slab[2].inverse < zero ? INTL(4) : INTL(0)));
  UintL key = octant | dominant_axis(p->direction) << 3;
  for (uint bits = lane_bits(waiting); bits; bits = lane_bits(waiting)) {
    uint lead = LANE_UINT(key, lowest_bit(bits));
    IntL group = waiting & (key == UINTL(lead));
    packet_walk(p, group, lead & 7, lead >> 3, nodes, triangles, any_hit, culls, attributes);
    waiting = waiting & !group;
  }
}

static inline void packet_trace(Packet *p, global const Bvh2Node *nodes, global const BvhTriangle *triangles,
                                bool any_hit, bool culls, const AttributeSources *attributes)
{
  packet_trace_lanes(p, p->t_max > FLOATL(0), nodes, triangles, any_hit, culls, attributes);
}

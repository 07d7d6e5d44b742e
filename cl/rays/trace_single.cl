// Traverse + intersect, one ray at a time over the 8-wide BVH: closest hit and any hit.
//
//   in, out   as in trace_packet.cl, with nodes of eight children and blocks of eight triangles
//
//   Pro   rays that share nothing: the vector is filled by the children of one node, not by neighbouring rays.
//   Con   slower than packets for camera rays; on a GPU slower than two-child nodes (trace_packet.cl with one lane).
//   Cost  about log8(triangles) node tests a ray; 256 bytes a node, 352 a block.
//
// The eight lanes here are children and triangles whatever LANES is; the arithmetic of a triangle is that of
// lib/triangle.cl, so that both kernels return the same bits.
//
//   From  Wald, Benthin, Boulos, "Getting Rid of Packets", 2008; Ize, "Robust BVH Ray Traversal", JCGT 2013.

#undef LANES
#define LANES 8
#include "lib/hit.cl"
#include "lib/ray_stream.cl"
#include "lib/slab.cl"
#include "lib/triangle.cl"

#define STACK_SIZE 448  // above 7 x BVH_MAX_DEPTH of host/accel

typedef struct Ray {
  SlabAxis slab[3];
  uint sign[3];  // 1 where the direction is negative
  uint kx, ky, kz;
  ShearedRay sheared;
  IntL positive_kz;
  float t_min;
  float t, u, v;
  uint id;
  int absorption;  // of BLEND surfaces met (lib/alpha.cl)
} Ray;

static inline Ray ray_load(global const float *rays, uint capacity, uint index, float t_min)
{
  Ray ray;
  Vec3L origin, direction;
  float o[3], d[3];
  for (uint axis = 0; axis < 3; axis++) {
    o[axis] = rays[(RAY_ORIGIN_X + axis) * capacity + index];
    d[axis] = rays[(RAY_DIRECTION_X + axis) * capacity + index];
    ray.slab[axis] = slab_axis(FLOATL(o[axis]), FLOATL(d[axis]));
    ray.sign[axis] = LANE_FLOAT(ray.slab[axis].inverse, 0) < 0;
  }
  origin = vec3l(FLOATL(o[0]), FLOATL(o[1]), FLOATL(o[2]));
  direction = vec3l(FLOATL(d[0]), FLOATL(d[1]), FLOATL(d[2]));
  float x = fabs(d[0]), y = fabs(d[1]), z = fabs(d[2]);
  ray.kz = (x >= y && x >= z) ? 0 : (y >= z) ? 1 : 2;
  ray.kx = ray.kz == 2 ? 0 : ray.kz + 1;
  ray.ky = ray.kz == 0 ? 2 : ray.kz - 1;
  ray.sheared = shear_ray(origin, direction, ray.kz);
  ray.positive_kz = INTL(d[ray.kz] > 0 ? -1 : 0);
  ray.t_min = t_min;
  ray.t = rays[RAY_T_MAX * capacity + index];
  ray.u = ray.v = 0;
  ray.id = HIT_NONE;
  ray.absorption = 0;
  return ray;
}

// Tests a block; any hit: returns whether one blocks the ray; closest: keeps the nearest.
static inline bool ray_block(Ray *ray, global const Bvh8Block *block, bool any_hit, bool culls,
                             const AttributeSources *attributes)
{
  uint kx = ray->kx, ky = ray->ky, kz = ray->kz;
  TriangleHit hit = triangle_intersect(
      &ray->sheared, vload8(0, block->vertex[0][kx]), vload8(0, block->vertex[0][ky]), vload8(0, block->vertex[0][kz]),
      vload8(0, block->vertex[1][kx]), vload8(0, block->vertex[1][ky]), vload8(0, block->vertex[1][kz]),
      vload8(0, block->vertex[2][kx]), vload8(0, block->vertex[2][ky]), vload8(0, block->vertex[2][kz]));
  FloatL limit = FLOATL(ray->t);
  IntL accept = hit.inside & (hit.t > FLOATL(ray->t_min)) & (any_hit ? hit.t < limit : hit.t <= limit);
  if (!any_lane(accept)) return false;
  if (any_lane(accept & hit.doubtful)) {
    FloatL vertex[3][3];
    for (uint corner = 0; corner < 3; corner++)
      for (uint axis = 0; axis < 3; axis++) vertex[corner][axis] = vload8(0, block->vertex[corner][axis]);
    hit_hold(&hit, FLOATL(ray->t_min), ray->slab, vertex[0], vertex[1], vertex[2]);
    accept = accept & hit.inside & (any_hit ? hit.t < limit : hit.t <= limit);
  }
  accept = accept & (hit.t > hit.t_error);
  if (any_hit) accept = accept & hit_before_end(&hit, limit);
  UintL flags = vload8(0, block->flags);
  if (any_hit && !culls) accept = accept & !lanes_shadowless(flags);
  if (culls)
    accept = accept &
             (((flags & UINTL(TRIANGLE_SINGLE_SIDED)) == UINTL(0)) | (hit.determinant_positive == ray->positive_kz));
  for (uint bits = lane_bits(accept); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    float t = LANE_FLOAT(hit.t, lane);
    uint id = block->id[lane];
    if (!any_hit && !(t < ray->t || (t == ray->t && id < ray->id))) continue;
#ifdef HAS_MASK
    if ((LANE_UINT(flags, lane) & TRIANGLE_MASKED) &&
        !(lane_bits(alpha_passes(attributes, id, LANE_INDEX == INTL((int)lane), hit.u, hit.v)) >> lane & 1))
      continue;
#endif
#ifdef HAS_BLEND
    if (any_hit && (LANE_UINT(flags, lane) & TRIANGLE_BLENDED)) {
      if (lane > 0 && id == block->id[lane - 1]) continue;  // an unused slot repeats the one before it
      IntL absorbed = alpha_absorption(attributes, id, LANE_INDEX == INTL((int)lane), hit.u, hit.v);
      ray->absorption += LANE_INT(absorbed, lane);
      if (ray->absorption < ABSORPTION_ALL) continue;
    }
#endif
    if (any_hit) return true;
    ray->t = t;
    ray->u = LANE_FLOAT(hit.u, lane);
    ray->v = LANE_FLOAT(hit.v, lane);
    ray->id = id;
  }
  return false;
}

// Walks the tree; returns true at once when any_hit and something blocks the ray.
static inline bool ray_walk(Ray *ray, global const Bvh8Node *nodes, global const Bvh8Block *blocks, bool any_hit,
                            bool culls, const AttributeSources *attributes)
{
  uint stack_child[STACK_SIZE];
  float stack_enter[STACK_SIZE];
  uint top = 0, child = 0;
  for (;;) {
    if (child & BVH_LEAF) {
      if (ray_block(ray, &blocks[child & ~BVH_LEAF], any_hit, culls, attributes)) return true;
    } else {
      global const Bvh8Node *node = &nodes[child];
      FloatL enter = max_lane(slab_near(&ray->slab[0], vload8(0, node->bounds[0][ray->sign[0]])), FLOATL(ray->t_min));
      enter = max_lane(slab_near(&ray->slab[1], vload8(0, node->bounds[1][ray->sign[1]])), enter);
      enter = max_lane(slab_near(&ray->slab[2], vload8(0, node->bounds[2][ray->sign[2]])), enter);
      FloatL leave = min_lane(slab_far(&ray->slab[0], vload8(0, node->bounds[0][1 - ray->sign[0]])), FLOATL(ray->t));
      leave = min_lane(slab_far(&ray->slab[1], vload8(0, node->bounds[1][1 - ray->sign[1]])), leave);
      leave = min_lane(slab_far(&ray->slab[2], vload8(0, node->bounds[2][1 - ray->sign[2]])), leave);
      uint bits = lane_bits(enter <= leave * FLOATL(BOX_PADDING));
      uint bottom = top;
      for (; bits; bits &= bits - 1) {
        uint lane = lowest_bit(bits);
        float at = LANE_FLOAT(enter, lane);
        uint place = top++;
        for (; !any_hit && place > bottom && stack_enter[place - 1] < at; place--) {
          stack_enter[place] = stack_enter[place - 1];
          stack_child[place] = stack_child[place - 1];
        }
        stack_enter[place] = at;
        stack_child[place] = node->child[lane];
      }
    }
    do {
      if (top == 0) return false;
      top--;
    } while (!(stack_enter[top] <= ray->t * BOX_PADDING));
    child = stack_child[top];
  }
}

kernel void trace_closest(global const Bvh8Node *nodes, global const Bvh8Block *blocks, global const float *rays,
                          uint capacity, uint ray_count, float t_min, global float *hits, global uint *hit_ids,
                          global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors,
                          uint vertex_count, global const MaterialInfo *materials, global const TextureInfo *textures,
                          global const uchar4 *texels, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint i = begin; i < end; i++) {
    Ray ray = ray_load(rays, capacity, i, t_min);
    if (ray.t > 0) ray_walk(&ray, nodes, blocks, false, true, &attributes);
    hits[HIT_T * capacity + i] = ray.t;
    hits[HIT_U * capacity + i] = ray.u;
    hits[HIT_V * capacity + i] = ray.v;
    hit_ids[i] = ray.id;
  }
}

// Any hit for the rays of one segment; `culls` is a constant.
static inline void trace_segment(global const Bvh8Node *nodes, global const Bvh8Block *blocks, global const float *rays,
                                 uint capacity, uint ray_count, global const uint *slots, global float4 *radiance,
                                 bool culls, const AttributeSources *attributes)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint i = begin; i < end; i++) {
    Ray ray = ray_load(rays, capacity, i, 0);
    if (ray.t < 0 || (ray.t > 0 && ray_walk(&ray, nodes, blocks, true, culls, attributes))) continue;
    float through = 1;
#ifdef HAS_BLEND
    through = exp2(ray.absorption * (-1 / ABSORPTION_UNITS));
#endif
    stream_add_weight(rays, capacity, i, slots, radiance, through);
  }
}

kernel void trace_any(global const Bvh8Node *nodes, global const Bvh8Block *blocks, global const float *rays,
                      uint capacity, uint ray_count, uint segment, global const uint *slots, global float4 *radiance,
                      global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors,
                      uint vertex_count, global const MaterialInfo *materials, global const TextureInfo *textures,
                      global const uchar4 *texels, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  trace_segment(nodes, blocks, rays + segment * RAY_FIELD_COUNT * capacity, capacity, ray_count,
                slots + segment * capacity, radiance, false, &attributes);
}

kernel void trace_open(global const Bvh8Node *nodes, global const Bvh8Block *blocks, global const float *rays,
                       uint capacity, uint ray_count, uint segment, global const uint *slots, global float4 *radiance,
                       global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors,
                       uint vertex_count, global const MaterialInfo *materials, global const TextureInfo *textures,
                       global const uchar4 *texels, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  trace_segment(nodes, blocks, rays + segment * RAY_FIELD_COUNT * capacity, capacity, ray_count,
                slots + segment * capacity, radiance, true, &attributes);
}

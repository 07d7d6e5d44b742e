// Hybrid shadows: the verdicts of trace_any, from what a light's maps know for sure (cl/raster/shadow_bins.cl), and the
// rays that remain.
//
//   in    rays, slots   a stream of shadow rays to `light`, [ray_count] of segment `segment`
//         infos, views  the maps of all lights
//         tiles, blocks, rows  what they know (shared/shadow.h)
//         triangles     in the order of the BVH's leaves
//         dark_alone    1: that nothing stops a ray is not believed
//   out   radiance[slot] gains the weight of rays that nothing stops
//         unsure_rays, _slots, count   rays that the maps cannot judge, for trace_any
//
//   A shadow ray is one point of the map. It is lit if it is closer to the light than all that its tile holds, or its
//   texel; dark if a triangle that hides all of the texel is closer (lib/sure_look.cl, which shading asks first: what
//   comes here it could not tell, and what has to wait for that). Between them it is dark if it meets a triangle that
//   the texel names, by the very function that rays ask, and lit if it meets none and is closer than all that are not
//   named. Else, where a BLEND surface is among them, and where no map knows of the point, it is unsure.
//
//   Pro   no bias: a verdict is the ray's. Most need one look at the map; neighbouring rays ask for the same
//         triangles, each of which is tested against all of them at once.
//   Fails where a ray begins within a closed surface by rounding, as where two touch: it may leave that by its lit side
//         alone, which is not in the map. That a ray is dark is true wherever it begins: rays that are more likely to
//         begin so, reflected by two mirrors or more, are judged by `dark_alone`.
//   Con   more than SHADOW_NUMBERS triangles between the texel's points and the light leave rays unsure: maps too small
//         for the mesh, or none of the mesh's pieces closed.
//   Cost  12 ns a ray on a core, in a room of closed surfaces.
//
//   From  Hertel, Hormann, Westermann, "A Hybrid GPU Rendering Pipeline for Alias-Free Hard Shadows", Eurographics 2009
//         (rays where the map is unsure); Lauterbach, Mo, Manocha, "Fast Hard and Soft Shadow Generation on Complex
//         Models using Selective Ray Tracing", 2009.

#include "lib/packet.cl"
#include "lib/radiance.cl"
#include "lib/sure_look.cl"
#include "shared/shadow.h"

// Triangles that a packet has tested of late: those of several lanes are mostly the same.
#define TESTED 8

// Lanes of `group` that pass a triangle by no more than rounding.
static inline IntL packet_grazes(const Packet *p, IntL group, const ShearedRay *ray, uint kz,
                                 global const BvhTriangle *triangle)
{
  TriangleHit hit = packet_triangle(triangle, ray, kz);
  return group & hit.close & !(hit.t < FLOATL(0) - hit.t_error) & !(hit.t - hit.t_error > p->t_max);
}

// Tests the packet's lanes `group`, which share the dominant axis `kz`, against the triangles that their texels name
// and that may be closer to the light; returns those for which that is not enough: a BLEND surface is among them, or
// the edge of a closed surface is so near that the ray might meet the side that is left out.
static inline IntL named_walk(Packet *p, IntL group, uint kz, const TexelLook *look, UintL block, UintL row_count,
                              const SureSources *of, const AttributeSources *attributes)
{
  global const BvhTriangle *triangles = of->triangles;
  ShearedRay ray = shear_ray(p->origin, p->direction, kz);
  IntL positive_kz = component3(p->direction, kz) > FLOATL(0), unclear = INTL(0), left = group;
  UintL texel = look->texel;
  FloatL closeness = look->closeness - look->slack;
  uint tested[TESTED], turn = 0;
  for (uint i = 0; i < TESTED; i++) tested[i] = HIT_NONE;
  for (uint k = 0; k < SHADOW_NUMBERS; k++) {
    left = left & !p->occluded;
    for (uint bits = lane_bits(left); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits), at = LANE_UINT(block, lane), entry = LANE_UINT(texel, lane);
      global const ShadowRow *row = k ? &of->rows[(k - 1) * of->block_count + at] : &of->blocks[at].first;
      if (k >= LANE_UINT(row_count, lane) || LANE_FLOAT(closeness, lane) > row->near[entry]) {
        left = left & (LANE_INDEX != INTL((int)lane));
        continue;
      }
      uint name = row->number[entry], number = name & ~SHADOW_CLOSED;
      bool known = false;
      for (uint i = 0; i < TESTED; i++) known |= tested[i] == number;
#ifdef HAS_BLEND
      if (triangles[number].flags & TRIANGLE_BLENDED) {
        unclear = unclear | (group & (LANE_INDEX == INTL((int)lane)));
        continue;
      }
#endif
      if (known) continue;
      tested[turn++ % TESTED] = number;
      if (name & SHADOW_CLOSED) unclear = unclear | packet_grazes(p, group, &ray, kz, &triangles[number]);
      packet_leaf(p, group, &ray, kz, positive_kz, triangles, number, 1, true, false, attributes);
      bits &= lane_bits(!p->occluded) | (bits & -bits);
    }
  }
  return unclear;
}

// What the triangles tell that the texels of those that wait name. All other rays are unsure.
static inline void named_judge(Verdicts *v, const TexelLook *look, Packet *p, const SureSources *of,
                               const AttributeSources *attributes)
{
  UintL axis = dominant_axis(p->direction), row_count = UINTL(0);
  FloatL rest = FLOATL(INFINITY);
  IntL unclear = INTL(0);
  for (uint bits = lane_bits(v->waiting); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    global const ShadowBlock *block = &of->blocks[LANE_UINT(v->block, lane)];
    LANE_FLOAT(rest, lane) = block->rest[LANE_UINT(look->texel, lane)];
    LANE_UINT(row_count, lane) = block->row_count;
  }
  for (uint kz = 0; kz < 3; kz++) {
    IntL group = v->waiting & (axis == UINTL(kz));
    if (any_lane(group)) unclear = unclear | named_walk(p, group, kz, look, v->block, row_count, of, attributes);
  }
  v->dark = v->dark | (v->waiting & p->occluded);
  v->lit = v->lit | (v->waiting & !p->occluded & !unclear & (look->closeness - look->slack > rest));
}

// Adds the weights of the lanes `lit`; of `valid` all are in the stream.
static inline void weights_add(IntL lit, IntL valid, global const float *rays, uint capacity, uint first,
                               global const uint *slots, global float4 *radiance)
{
  if (!any_lane(lit)) return;
  UintL slot = LANE_LOAD(slots, first);
  IntL touched = slots_follow(slot, valid) ? valid : lit;  // whole vectors are quicker
  Sum sum = radiance_load(radiance, slot, touched);
  sum.rgb = select3(lit, add3(sum.rgb, stream_load3(rays, capacity, RAY_WEIGHT_R, first)), sum.rgb);
  radiance_store(radiance, slot, touched, sum);
}

kernel void shadow_hybrid(global const ShadowInfo *infos, uint light, global const ShadowView *views,
                          global const ShadowTile *tiles, global const ShadowBlock *blocks,
                          global const ShadowRow *rows, uint block_count, global const BvhTriangle *triangles,
                          global const float *rays, uint capacity, uint ray_count, uint segment, uint dark_alone,
                          global const uint *slots, global float4 *radiance, global float *unsure_rays,
                          global uint *unsure_slots, global uint *unsure_count, global const TriangleCorners *corners,
                          global const Float2 *uvs, global const Float4 *colors, uint vertex_count,
                          global const MaterialInfo *materials, global const TextureInfo *textures,
                          global const uchar4 *texel_bytes, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners,   uvs,      colors,      vertex_count,
                                 materials, textures, texel_bytes, linear_from_byte};
  SureSources of = {tiles, blocks, rows, block_count, triangles};
  rays += segment * RAY_FIELD_COUNT * capacity;
  slots += segment * capacity;
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    Vec3L origin = stream_load3(rays, capacity, RAY_ORIGIN_X, first);
    IntL active = stream_load_t_max(rays, capacity, first, ray_count) > FLOATL(0);
    IntL valid = LANE_INDEX < INTL((int)(ray_count - first));
    TexelLook look;
    Verdicts v = sure_judge(&look, &infos[light], views, &of, origin, active);
    if (any_lane(v.waiting)) {
      Packet p = packet_load(rays, capacity, first, ray_count, 0);
      named_judge(&v, &look, &p, &of, &attributes);
    }
    if (dark_alone) v.lit = INTL(0);
    weights_add(v.lit, valid, rays, capacity, first, slots, radiance);
    IntL unsure = active & !(v.lit | v.dark);
    if (any_lane(unsure))
      stream_append(unsure, origin, stream_load3(rays, capacity, RAY_DIRECTION_X, first),
                    LANE_LOAD(rays + RAY_T_MAX * capacity, first), stream_load3(rays, capacity, RAY_WEIGHT_R, first),
                    LANE_LOAD(slots, first), unsure_rays, capacity, unsure_slots, unsure_count);
  }
}

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
//   texel; dark if a triangle that hides all of the texel is closer (lib/sure_look.cl). Between them it is dark if it
//   meets a triangle that the texel names, by the very function that rays ask, and lit if it meets none and is closer
//   than all that are not named (lib/sure_named.cl). Else, where a BLEND surface is among them, and where no map knows
//   of the point, it is unsure. Shading asks the same first, on a GPU without the named triangles: what comes here it
//   did not ask about, could not tell, or has to let wait for that.
//
//   Pro   no bias: a verdict is the ray's. Most need one look at the map; neighbouring rays ask for the same
//         triangles, each of which is tested against all of them at once.
//   Fails where a ray begins within a closed surface by rounding, as where two touch: it may leave that by its lit side
//         alone, which is not in the map. That a ray is dark is true wherever it begins: rays that are more likely to
//         begin so, reflected by two mirrors or more, are judged by `dark_alone`.
//   Con   more than SHADOW_NUMBERS triangles between the texel's points and the light leave rays unsure: maps too small
//         for the mesh, or none of the mesh's pieces closed.
//   Cost  7 to 37 ns a ray on a core in shading, by the share that comes to named triangles, with the rays traced then.
//
//   From  Hertel, Hormann, Westermann, "A Hybrid GPU Rendering Pipeline for Alias-Free Hard Shadows", Eurographics 2009
//         (rays where the map is unsure); Lauterbach, Mo, Manocha, "Fast Hard and Soft Shadow Generation on Complex
//         Models using Selective Ray Tracing", 2009.

#include "lib/radiance.cl"
#include "lib/sure_named.cl"

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
    Verdicts v = sure_look(&look, &infos[light], views, &of, origin, active, NULL);
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

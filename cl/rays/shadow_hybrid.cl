// Hybrid shadows: the verdicts of trace_any, from what a light's maps know for sure (cl/raster/shadow_bins.cl), and the
// rays that remain.
//
//   in    rays, slots   a stream of shadow rays to one light, [ray_count] of segment `segment`
//         info, views   the light's maps
//         blocks, rows  what they know (shared/shadow.h)
//         triangles     in the order of the BVH's leaves
//   out   radiance[slot] gains the weight of rays that nothing stops
//         unsure_rays, _slots, count   rays that the maps cannot judge, for trace_any
//
//   A shadow ray is one point of the map. It is lit if it is closer to the light than all that its texel holds; dark if
//   a triangle that hides all of the texel is closer. Between them it is dark if it meets a triangle that the texel
//   names, by the very function that rays ask, and lit if it meets none and is closer than all that are not named.
//   Else, where a BLEND surface is among them, and where no map holds the point, it is unsure.
//
//   Pro   no bias: a verdict is the ray's. Most need one look at the map; neighbouring rays ask for the same
//         triangles, each of which is tested against all of them at once.
//   Fails where a ray begins within a closed surface by rounding, as where two touch: it may leave that by its lit side
//         alone, which is not in the map.
//   Con   more than SHADOW_NUMBERS triangles between the texel's points and the light leave rays unsure: maps too small
//         for the mesh, or none of the mesh's pieces closed.
//   Cost  12 ns a ray on a core, in a room of closed surfaces.
//
//   From  Hertel, Hormann, Westermann, "A Hybrid GPU Rendering Pipeline for Alias-Free Hard Shadows", Eurographics 2009
//         (rays where the map is unsure); Lauterbach, Mo, Manocha, "Fast Hard and Soft Shadow Generation on Complex
//         Models using Selective Ray Tracing", 2009.

#include "lib/packet.cl"
#include "lib/shadow_view.cl"

// Triangles that a packet has tested of late: those of several lanes are mostly the same.
#define TESTED 8

// What the maps know of the packet's points.
typedef struct TexelLook {
  IntL mapped;  // lanes that a map holds
  UintL block;  // index into the blocks
  UintL texel;  // of the block
  FloatL closeness, slack;
} TexelLook;

static inline TexelLook texels_look(global const ShadowInfo *info, global const ShadowView *views, Vec3L origin,
                                    IntL active)
{
  TexelLook look;
  UintL chosen = shadow_view_choose(info, views, origin);
  uint size = info->size_px, row_blocks = size / 4;
  look.mapped = active & (chosen != UINTL(SHADOW_VIEW_NONE));
  look.block = look.texel = UINTL(0);
  look.closeness = look.slack = FLOATL(0);
  for (uint bits = lane_bits(look.mapped); bits;) {
    uint number = LANE_UINT(chosen, lowest_bit(bits));
    IntL group = look.mapped & (chosen == UINTL(number));
    bits &= ~lane_bits(group);
    global const ShadowView *view = &views[number];
    MapPoint at = shadow_project(view, shadow_relative(view, origin));
    FloatL last = FLOATL((float)(size - 1)), zero = FLOATL(0), one = FLOATL(1);
    UintL x = LANE_AS_UINT(LANE_CONVERT_INT(min_lane(max_lane(at.x, zero), last)));
    UintL y = LANE_AS_UINT(LANE_CONVERT_INT(min_lane(max_lane(at.y, zero), last)));
    UintL block = (y >> UINTL(2)) * UINTL(row_blocks) + (x >> UINTL(2)) + UINTL(number * row_blocks * row_blocks);
    look.block = group ? block : look.block;
    look.texel = group ? (y & UINTL(3)) * UINTL(4) + (x & UINTL(3)) : look.texel;
    bool parallel = view->raster.parallel;
    FloatL closeness = parallel ? zero - at.depth : one / at.w;
    look.closeness = group ? closeness : look.closeness;
    look.slack =
        group ? (parallel ? FLOATL(SHADOW_ROUNDING_PARALLEL) : closeness * FLOATL(SHADOW_ROUNDING)) : look.slack;
  }
  return look;
}

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
static inline IntL named_walk(Packet *p, IntL group, uint kz, const TexelLook *look, UintL row_count,
                              global const ShadowBlock *blocks, global const ShadowRow *rows, uint block_count,
                              global const BvhTriangle *triangles, const AttributeSources *attributes)
{
  ShearedRay ray = shear_ray(p->origin, p->direction, kz);
  IntL positive_kz = component3(p->direction, kz) > FLOATL(0), unclear = INTL(0), left = group;
  UintL block = look->block, texel = look->texel;
  FloatL closeness = look->closeness - look->slack;
  uint tested[TESTED], turn = 0;
  for (uint i = 0; i < TESTED; i++) tested[i] = HIT_NONE;
  for (uint k = 0; k < SHADOW_NUMBERS; k++) {
    left = left & !p->occluded;
    for (uint bits = lane_bits(left); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits), at = LANE_UINT(block, lane), entry = LANE_UINT(texel, lane);
      global const ShadowRow *row = k ? &rows[(k - 1) * block_count + at] : &blocks[at].first;
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

kernel void shadow_hybrid(global const ShadowInfo *info, global const ShadowView *views,
                          global const ShadowBlock *blocks, global const ShadowRow *rows,
                          global const BvhTriangle *triangles, global const float *rays, uint capacity, uint ray_count,
                          uint segment, global const uint *slots, global float4 *radiance, global float *unsure_rays,
                          global uint *unsure_slots, global uint *unsure_count, global const TriangleCorners *corners,
                          global const Float2 *uvs, global const Float4 *colors, uint vertex_count,
                          global const MaterialInfo *materials, global const TextureInfo *textures,
                          global const uchar4 *texel_bytes, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners,   uvs,      colors,      vertex_count,
                                 materials, textures, texel_bytes, linear_from_byte};
  rays += segment * RAY_FIELD_COUNT * capacity;
  slots += segment * capacity;
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  uint block_count = info->view_count * (info->size_px / 4) * (info->size_px / 4);
  for (uint first = begin; first < end; first += LANES) {
    Vec3L origin = stream_load3(rays, capacity, RAY_ORIGIN_X, first);
    IntL active = stream_load_t_max(rays, capacity, first, ray_count) > FLOATL(0);
    TexelLook look = texels_look(info, views, origin, active);
    FloatL nearest = FLOATL(INFINITY), covered = FLOATL(-INFINITY);
    for (uint bits = lane_bits(look.mapped); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits), texel = LANE_UINT(look.texel, lane);
      global const ShadowBlock *block = &blocks[LANE_UINT(look.block, lane)];
      LANE_FLOAT(nearest, lane) = block->first.near[texel];
      LANE_FLOAT(covered, lane) = block->covered[texel];
    }
    IntL lit = look.mapped & (look.closeness - look.slack > nearest);
    IntL dark = look.mapped & (look.closeness + look.slack < covered);
    IntL waiting = look.mapped & !(lit | dark);
    if (any_lane(waiting)) {
      Packet p = packet_load(rays, capacity, first, ray_count, 0);
      UintL axis = dominant_axis(p.direction);
      UintL row_count = UINTL(0);
      FloatL rest = FLOATL(INFINITY);
      IntL unclear = INTL(0);
      for (uint bits = lane_bits(waiting); bits; bits &= bits - 1) {
        uint lane = lowest_bit(bits);
        global const ShadowBlock *block = &blocks[LANE_UINT(look.block, lane)];
        LANE_FLOAT(rest, lane) = block->rest[LANE_UINT(look.texel, lane)];
        LANE_UINT(row_count, lane) = block->row_count;
      }
      for (uint kz = 0; kz < 3; kz++) {
        IntL group = waiting & (axis == UINTL(kz));
        if (any_lane(group))
          unclear =
              unclear | named_walk(&p, group, kz, &look, row_count, blocks, rows, block_count, triangles, &attributes);
      }
      dark = dark | (waiting & p.occluded);
      lit = lit | (waiting & !p.occluded & !unclear & (look.closeness - look.slack > rest));
    }
    for (uint bits = lane_bits(lit); bits; bits &= bits - 1)
      stream_add_weight(rays, capacity, first + lowest_bit(bits), slots, radiance, 1);
    IntL unsure = active & !(lit | dark);
    if (any_lane(unsure))
      stream_append(unsure, origin, stream_load3(rays, capacity, RAY_DIRECTION_X, first),
                    LANE_LOAD(rays + RAY_T_MAX * capacity, first), stream_load3(rays, capacity, RAY_WEIGHT_R, first),
                    LANE_LOAD(slots, first), unsure_rays, capacity, unsure_slots, unsure_count);
  }
}

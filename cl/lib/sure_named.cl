// What the triangles that texels name (ShadowRow of shared/shadow.h) tell of shadow rays of which a look at the maps
// (lib/sure_look.cl) could not: each is tested against all rays of a packet at once, by the very function that rays
// ask.

#include "lib/packet.cl"
#include "lib/sure_look.cl"

// Triangles that a packet has tested of late: those of several lanes are mostly the same.
typedef struct Tested {
  uint8 number;
} Tested;

static inline bool tested_before(const Tested *tested, uint number)
{
  return as_ulong(convert_char8(tested->number == (uint8)(number))) != 0;
}

static inline void tested_add(Tested *tested, uint number)
{
  tested->number = tested->number.s70123456;
  tested->number.s0 = number;
}

// Tests the packet's lanes `group` against triangle `name`. Of a closed surface: returns those that pass it by no more
// than rounding.
static inline IntL named_meet(Packet *p, IntL group, const ShearedRay *ray, uint kz, IntL positive_kz, uint name,
                              global const BvhTriangle *triangle, const AttributeSources *attributes)
{
  TriangleEdges edges = packet_edges(triangle, ray, kz);
  group = group & !p->occluded;
  if (any_lane(group & edges.inside)) {
    TriangleHit hit = triangle_hit(&edges, ray);
    packet_meet(p, &hit, group, positive_kz, triangle, true, false, attributes);
    group = group & !p->occluded;
  }
  if (!(name & SHADOW_CLOSED) || !any_lane(group)) return INTL(0);
  FloatL z;
  IntL grazes = group & triangle_close(&edges, triangle_edge_terms(&z, &edges));
  if (!any_lane(grazes)) return grazes;
  TriangleHit hit = triangle_hit(&edges, ray);
  return grazes & !(hit.t < FLOATL(0) - hit.t_error) & !(hit.t - hit.t_error > p->t_max);
}

// What row `k` of lists says to the lanes `mask`; nothing where they are shorter. Asks for the next row.
static inline void row_look(FloatL *near, UintL *name, uint k, IntL mask, UintL block, UintL texel,
                            const SureSources *of)
{
  *near = FLOATL(-INFINITY);
  *name = UINTL(0);
  for (uint bits = lane_bits(mask); bits;) {
    uint at = LANE_UINT(block, lowest_bit(bits));
    IntL same = mask & (block == UINTL(at));
    bits &= ~lane_bits(same);
    if (k && k >= of->blocks[at].row_count) continue;
    global const ShadowRow *row = k ? &of->rows[(k - 1) * of->block_count + at] : &of->blocks[at].first;
    *near = table_pick(row->near, texel, same, *near);
    *name = table_pick_uint(row->number, texel, same, *name);
#ifdef HAS_PREFETCH
    PREFETCH(of->rows[k * of->block_count + at].near);
    PREFETCH(of->rows[k * of->block_count + at].number);
#endif
  }
}

// Asks for the triangles that the lanes of `mask` name, as all of them are tested soon.
static inline void triangles_prefetch(global const BvhTriangle *triangles, UintL names, IntL mask)
{
#ifdef HAS_PREFETCH
  for (uint bits = lane_bits(mask); bits;) {
    uint name = LANE_UINT(names, lowest_bit(bits));
    bits &= ~lane_bits(mask & (names == UINTL(name)));
    global const BvhTriangle *triangle = &triangles[name & ~SHADOW_CLOSED];
    PREFETCH(triangle);
    PREFETCH(triangle->vertex[2] + 2);
  }
#endif
}

// Tests the packet's lanes `group`, which share the dominant axis `kz`, against the triangles that their texels name
// and that may be closer to the light; returns those for which that is not enough: a BLEND surface is among them, or
// the edge of a closed surface is so near that the ray might meet the side that is left out.
static inline IntL named_walk(Packet *p, IntL group, uint kz, const TexelLook *look, UintL block, const SureSources *of,
                              const AttributeSources *attributes)
{
  ShearedRay ray = shear_ray(p->origin, p->direction, kz);
  IntL positive_kz = component3(p->direction, kz) > FLOATL(0), unclear = INTL(0), left = group;
  Tested tested = {(uint8)(HIT_NONE)};
  for (uint k = 0; k < SHADOW_NUMBERS; k++) {
    left = left & !p->occluded;
    if (!any_lane(left)) break;
    FloatL near;
    UintL names;
    row_look(&near, &names, k, left, block, look->texel, of);
    left = left & !(look->closeness - look->slack > near);
    triangles_prefetch(of->triangles, names, left);
    for (uint bits = lane_bits(left); bits;) {
      uint name = LANE_UINT(names, lowest_bit(bits)), number = name & ~SHADOW_CLOSED;
      IntL same = left & (names == UINTL(name));
      bits &= ~lane_bits(same);
#ifdef HAS_BLEND
      if (of->triangles[number].flags & TRIANGLE_BLENDED) {
        unclear = unclear | same;
        continue;
      }
#endif
      if (tested_before(&tested, number)) continue;
      tested_add(&tested, number);
      unclear = unclear | named_meet(p, group, &ray, kz, positive_kz, name, &of->triangles[number], attributes);
      bits &= lane_bits(!p->occluded);
    }
  }
  return unclear;
}

// Judges the rays that wait. All that then are neither lit nor dark are unsure.
static inline void named_judge(Verdicts *v, const TexelLook *look, Packet *p, const SureSources *of,
                               const AttributeSources *attributes)
{
  UintL axis = dominant_axis(p->direction);
  IntL unclear = INTL(0);
  for (uint kz = 0; kz < 3; kz++) {
    IntL group = v->waiting & (axis == UINTL(kz));
    if (any_lane(group)) unclear = unclear | named_walk(p, group, kz, look, v->block, of, attributes);
  }
  v->dark = v->dark | (v->waiting & p->occluded);
  IntL passed = v->waiting & !p->occluded & !unclear;
  for (uint bits = lane_bits(passed); bits;) {
    uint number = LANE_UINT(v->block, lowest_bit(bits));
    IntL same = passed & (v->block == UINTL(number));
    bits &= ~lane_bits(same);
    FloatL rest = table_pick(of->blocks[number].rest, look->texel, same, FLOATL(INFINITY));
    v->lit = v->lit | (look->closeness - look->slack > rest);
  }
}

// Shadow rays from hits.
typedef struct SureRays {
  Vec3L origin, direction;
  FloatL t_max;
  UintL own;  // the triangles that they start on
} SureRays;

// Judges the rays `active` to a light. Those that are neither lit nor dark are unsure. *view: of the light, where they
// were looked up.
static inline Verdicts sure_judge(UintL *view, const SureRays *rays, global const ShadowInfo *info,
                                  global const ShadowView *views, const SureSources *of, IntL active,
                                  const AttributeSources *attributes)
{
  TexelLook look;
  Verdicts v = sure_look(&look, info, views, of, rays->origin, active, &rays->own);
  *view = look.view;
#if LANES > 1
  if (any_lane(v.waiting)) {
    Packet p = packet_make(rays->origin, rays->direction, 0, rays->t_max);
    named_judge(&v, &look, &p, of, attributes);
  }
#endif
  return v;
}

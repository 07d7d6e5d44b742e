// Tiles of camera rays that all see the same: nothing, or one triangle. Most do where a picture shows sky and ground:
// what is asked of such a tile at once need not be asked of each vector of its lanes. For a CPU device.
//
//   Cost  2 ns a tile to find it; 18 ns to fill one that sees nothing, where the background is the same all over;
//   40 ns to ask a light's map about one where squares of blocks tell, which are asked where it spans more than two
//   blocks; its four vectors would take 220.

// What maps tell of all of a tile. Bit i of `lit`: light i of the batch reaches all of it; of `dark`: nothing of it.
typedef struct TileVerdicts {
  uint lit, dark;
} TileVerdicts;

#if LANES > 1 && RAYS_PER_ITEM == TILE_PIXELS
#define HAS_WHOLE_TILES

// Do all slots of a tile, of which `first` is the first, hold the same id?
static inline bool tile_is_whole(global const uint *hit_ids, uint first)
{
  UintL id = UINTL(hit_ids[first]);
  IntL other = INTL(0);
#pragma unroll
  for (uint i = 0; i < TILE_PIXELS; i += LANES) other = other | (LANE_LOAD(hit_ids + first, i) != id);
  return !any_lane(other);
}

// Do camera rays that leave the scene see the same everywhere? It is in *seen then.
static inline bool misses_are_even(Float3 *seen, const ShadeInfo *shade, constant EnvironmentInfo *environment)
{
  const bool flat = shade->primary && shade->flat_background;
  *seen = flat ? shade->background : environment->zenith;
  return flat || environment->kind == ENVIRONMENT_KIND_CONSTANT;
}

// Keeps what all slots of a tile see, as sum_keep does. False, and nothing is kept, where the tile lies partly outside
// the picture.
static inline bool tile_keep(global float4 *radiance, const ShadeInfo *shade, const TileView *tile, uint first,
                             Float3 seen)
{
  const bool to_picture = shade->to_picture != SHADE_TO_SLOTS, adds = shade->to_picture == SHADE_TO_PICTURE;
  uint width = tile->camera->width;
  if (tile->px.x + TILE_SIZE > width || tile->px.y + TILE_SIZE > tile->camera->height) return false;
  const float16 four = ((float4)(seen.x, seen.y, seen.z, 0)).xyzwxyzwxyzwxyzw;
  for (uint row = 0; row < TILE_SIZE; row++) {
    uint place = to_picture ? (tile->px.y + row) * width + tile->px.x : first + row * TILE_SIZE;
    global float *to = (global float *)(radiance + place);
    for (uint half_row = 0; half_row < 2; half_row++)
      vstore16(adds ? vload16(half_row, to) + four : four, half_row, to);
  }
  return true;
}

#ifdef HAS_SHADOW_MAPS
#define TILE_ROUNDING_PX 0.125f  // of places in a map

// Where shadow rays start at a tile's corners, by lane, and the triangle's normal there, to the viewer.
typedef struct TileCorners {
  Vec3L origin, geometric;
} TileCorners;

// Of a tile that shows the triangle `on`.
static inline TileCorners tile_corners(const WaveTile *tile, const HitTriangles *on, global const float *hits,
                                       uint capacity, uint first)
{
  IntL one = INTL(1), lane = INTL(0) + LANE_INDEX, right = lane & one, lower = lane >> one & one;
  IntL slot = right * INTL((int)tile_slot(TILE_SIZE - 1, 0)) + lower * INTL((int)tile_slot(0, TILE_SIZE - 1));
  UintL x = UINTL(tile->view.px.x) + LANE_AS_UINT(right * INTL(TILE_SIZE - 1));
  UintL y = UINTL(tile->view.px.y) + LANE_AS_UINT(lower * INTL(TILE_SIZE - 1));
  FloatL u = LANE_GATHER(FloatL, hits + HIT_U * capacity + first, slot), zero = FLOATL(0);
  FloatL v = LANE_GATHER(FloatL, hits + HIT_V * capacity + first, slot);
  IntL behind = dot3(on->geometric, camera_ray(tile->view.camera, x, y, tile->offset).direction) > zero;
  TileCorners out;
  out.geometric = select3(behind, sub3(vec3l(zero, zero, zero), on->geometric), on->geometric);
  out.origin = add3(blend3(on->p[0], on->p[1], on->p[2], u, v), position_offset(on->p, u, v, out.geometric));
  return out;
}

// kernels_judge of a tile: as a part of a plane it lies between its corners in any view of it from one side.
static inline int tile_judge(global const ShadowInfo *info, global const ShadowView *views, global const float *maps,
                             const TileCorners *corners)
{
  if (!info->view_count || info->method != SHADOW_BY_PCF || info->views != SHADOW_VIEWS_ONE) return -1;
  global const ShadowView *view = views + info->first_view;
  LightMap map = light_map(info, maps + info->first_texel, 0);
  ShadowLookup lookup = shadow_lookup(info, view, corners->origin, corners->geometric);
  if (any_lane(!shadow_in_view(&lookup.at, info, view->raster.parallel))) return -1;
  const float side = (float)info->kernel_px + 2 * TILE_ROUNDING_PX;
  const float4 box = points_box(&lookup.at, INTL(-1)), spans = box.zwzw - box.xyxy + side;
  int all = -1;
  if (max(spans.x, spans.y) > 2 * 4 && depth_map_is_wide(map.size))
    all = kernels_judge(map.wide, map.size, DEPTH_WIDE_PX, side, box, &lookup.at, &lookup.plane, 0);
  return all >= 0 ? all : kernels_judge(map.planes, map.size, 4, side, box, &lookup.at, &lookup.plane, 0);
}

// Of a tile that shows the triangle `on`.
static inline TileVerdicts tile_verdicts(const ShadeInfo *shade, const WaveTile *tile, const HitTriangles *on,
                                         global const float *hits, uint capacity, uint first,
                                         global const ShadowInfo *infos, global const ShadowView *views,
                                         global const float *maps)
{
  TileVerdicts told = {0, 0};
  TileCorners corners = tile_corners(tile, on, hits, capacity, first);
  for (uint i = 0; i < shade->light_count; i++) {
    if (!(shade->casting_lights >> i & 1)) continue;
    int lit = tile_judge(&infos[shade->first_light + i], views, maps, &corners);
    told.lit |= (lit > 0 ? 1u : 0u) << i;
    told.dark |= (lit == 0 ? 1u : 0u) << i;
  }
  return told;
}
#endif
#endif

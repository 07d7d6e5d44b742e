// Shade + spawn: light that hits send back along their rays, shadow rays to the lights, reflected rays.
//
//   in    rays, slots, hits, hit_ids   a stream and what trace_closest found, [ray_count]; with shade->from_camera hits
//                                      alone: the wave's camera rays are made here from cameras and offsets
//         keys                         with HAS_KEYS and shade->from_keys, in place of hits: what raster left
//                                      (lib/key_hit.cl)
//         scene arrays                 host/device_scene
//   out   radiance[slot]               emission, ambient, environment; light that needs no shadow ray: added, but the
//                                      first batch of camera rays sets all slots. With shade->to_picture it is the sums
//                                      of a picture, by pixel
//         shadow_rays, shadow_slots    one stream a light of the batch, weight = radiance if unblocked; after them the
//                                      environment's own (shared/shade.h); with HAS_SHADOW_MAPS not for lights that
//                                      have maps (lib/shadow_lookup.cl), with HAS_SURE_MAPS not for what these tell at
//                                      a look (lib/sure_look.cl)
//         reflected_rays, _slots       weight = throughput
//         transmitted_rays, _slots     what BLEND surfaces let through, on along the ray; with HAS_BLEND
//         counts                       STREAM_COUNTS of both
//
//   Tiles of camera rays that all see the same are treated as a whole where that is quicker (lib/whole_tile.cl).
//   Cost  one material and light_count lights a ray; reads about 200 bytes a ray, writes 44 a shadow or reflected ray.
//   A reflected ray that an interpolated normal would send into the triangle is mirrored at its plane instead.
//   HAS_LOBES: rough surfaces reflect, or the environment's light is sampled (lib/surface_samples.cl);
//   HAS_OCCLUSION_RAYS: it is weakened by ambient occlusion.
//   Verdicts that the frame before left of the same shadow rays are taken from there (lib/kept_verdicts.cl), and those
//   of this frame left there: kept_verdicts, of the picture's verdict_slots; 0: none.
//   HAS_ROUGH_MAPS: rough surfaces send one ray about which maps are asked (capture/cube_reflect.cl): its weight is the
//   lobe's albedo, its t_max the roughness.
//   A ray's radiance is added slot by slot in the order of launches: no atomics, the same sum on every run.
//   Streams are packed by one atomic per LANES rays; their order varies from run to run, the picture does not.

#include "lib/arrivals.cl"
#include "lib/light.cl"
#include "shared/bvh.h"
#include "shared/shadow.h"
#if defined(HAS_SHADOW_MAPS) || defined(HAS_SURE_MAPS)
#include "lib/shadow_view.cl"  // here, as a file is included once
#endif
#ifdef HAS_SHADOW_MAPS
#include "lib/shadow_lookup.cl"
#endif
#ifdef HAS_SURE_MAPS
#include "lib/kept_verdicts.cl"
#endif
#include "lib/whole_tile.cl"

static inline Vec3L mirror3(Vec3L to_eye, Vec3L n) { return sub3(scale3(n, FLOATL(2) * dot3(n, to_eye)), to_eye); }

// About where a rough surface reflects: the lobe leans to the normal as it widens. The fourth power of roughness for a
// shift was chosen by trial: it halves the error of roughness 0.7 to 1.
static inline Vec3L lobe_axis(const Surface *s, Vec3L to_eye)
{
  FloatL squared = s->reflectance.roughness * s->reflectance.roughness;
  Vec3L mirrored = mirror3(to_eye, s->normal);
  return unit3(add3(mirrored, scale3(sub3(s->normal, mirrored), squared * squared)));
}

// Light of the environment to the eye as if nothing stood before it; in the specular lobe only where no ray reflects.
// Diffuse: irradiance in nine harmonics. Specular: the split sum, prefiltered radiance x albedo, which takes the lobe
// for one about the reflected direction whatever the eye's.
//   From  Karis, "Real Shading in Unreal Engine 4", 2013.
static inline Vec3L environment_light_open(const SampledSurface *at, Vec3L to_eye, FloatL nv, bool mean,
                                           constant EnvironmentInfo *environment, global const Float4 *pixels,
                                           global const Float4 *levels)
{
  const Surface *s = at->surface;
  IntL glossy = at->lit & !(at->reflects | s->reflectance.mirror);
  Vec3L irradiance = environment_mean(environment), prefiltered = irradiance;
  if (!mean) {
    irradiance = environment_irradiance(environment, s->normal);
    if (any_lane(glossy))
      prefiltered =
          environment_prefiltered(environment, pixels, levels, lobe_axis(s, to_eye), s->reflectance.roughness, glossy);
  }
  Vec3L diffuse = scale3(mul3(diffuse_albedo_pbr(&s->reflectance, nv), irradiance), s->occlusion);
  Vec3L specular = mul3(specular_albedo_fit(&s->reflectance, nv), prefiltered);
  return select3(glossy, add3(diffuse, specular), diffuse);
}

// Emission, and phong's ambient light.
static inline Vec3L surface_own_radiance(const Surface *s, const ShadeInfo *shade)
{
  Vec3L own = s->emission;
  if (shade->model == LIGHTING_MODEL_PHONG) own = add3(own, scale3(s->base, FLOATL(shade->ambient)));
  return select3(s->unlit, s->base, own);
}

// What rays that leave the scene bring: the environment, camera rays the background. Of what a lobe's sample finds, the
// part counts that samples of the image leave to it.
static inline Vec3L shade_misses(IntL missed, Vec3L direction, Vec3L weight, FloatL density, const ShadeInfo *shade,
                                 constant EnvironmentInfo *environment, global const Float4 *environment_pixels,
                                 global const float *environment_table)
{
  if (shade->primary && shade->flat_background) return mul3(BROADCAST3(shade->background), weight);
  if (environment->kind == ENVIRONMENT_KIND_CONSTANT) return mul3(BROADCAST3(environment->zenith), weight);
  ImagePlace place;
  Vec3L unit = unit3(direction), seen = environment_radiance_at(environment, environment_pixels, unit, missed, &place);
#ifdef HAS_LOBES
  if (shade->environment_table && !shade->primary) {
    FloatL by_light = environment_density(environment, environment_table, unit, seen, &place);
    seen = scale3(seen, FLOATL(1) / (FLOATL(1) + by_light / density));
  }
#endif
  return mul3(seen, weight);
}

#ifdef HAS_LOBES
#define STREAMS_HAVE_DENSITY true
#else
#define STREAMS_HAVE_DENSITY false
#endif

#ifdef HAS_RECEIVERS
#define SHADOWS_HAVE_RECEIVER true
#else
#define SHADOWS_HAVE_RECEIVER false
#endif

// Light of the environment at a hit, but for what is sent along rays.
static inline Vec3L environment_light_add(Vec3L sum, const SampledSurface *at, Vec3L to_eye, FloatL nv,
                                          const ShadeInfo *shade, constant EnvironmentInfo *environment,
                                          global const Float4 *pixels, global const Float4 *levels)
{
  bool mean = shade->environment_light == ENVIRONMENT_BY_MEAN;
  if (!mean && shade->environment_light != ENVIRONMENT_BY_HARMONICS) return sum;
  Vec3L light = environment_light_open(at, to_eye, nv, mean, environment, pixels, levels);
  return select3(at->lit, add3(sum, mul3(light, at->weight)), sum);
}

// Light of the environment that is sent along rays, with the lobe's reflection of the scene.
static inline void environment_light_spawn(SampledSurface *at, Vec3L to_eye, FloatL nv, const ShadeInfo *shade,
                                           constant EnvironmentInfo *environment, global const Float4 *pixels,
                                           global const float *table, global const Float4 *levels,
                                           const SampleStreams *to)
{
#ifdef HAS_OCCLUSION_RAYS
  if (shade->environment_light == ENVIRONMENT_BY_OCCLUSION) {
    at->random = random_source(shade, at->slot);
    occlusion_rays_spawn(at, environment_light_open(at, to_eye, nv, false, environment, pixels, levels), shade, to);
  }
#endif
#ifdef HAS_LOBES
  bool sampled = shade->environment_light == ENVIRONMENT_BY_SAMPLES;
  at->to_specular = sampled ? specular_share(&at->surface->reflectance, nv) : FLOATL(1);
  at->to_specular = at->by_map ? FLOATL(0) : at->to_specular;
  if (!sampled) at->lit = at->reflects & !at->by_map;
  if (!any_lane(at->lit)) return;
  FloatL below = min_lane(dot3(at->surface->normal, to_eye), FLOATL(0));
  at->view = sub3(to_eye, scale3(at->surface->normal, FLOATL(2) * below));
  at->random = random_source(shade, at->slot);
  if (shade->environment_table) light_sample_spawn(at, shade, environment, pixels, table, to);
  lobe_sample_spawn(at, shade, environment, pixels, table, to);
#endif
}

#ifdef HAS_SURE_MAPS
static inline void count_add(uint rays, global uint *count)
{
#if LANES == 1
  for (uint i = 0; i < rays; i++) place_take(count);  // one atomic for all work-items that come here together
#else
  if (rays) atomic_add(count, rays);
#endif
}
#endif

kernel void shade(const ShadeInfo settings, global const float *rays, global const uint *slots, uint capacity,
                  uint ray_count, global const float *hits, global const uint *hit_ids, global ulong *keys,
                  global const float *positions, global const float *normals, global const Float4 *tangents,
                  global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors,
                  uint vertex_count, global const MaterialInfo *materials, global const TextureInfo *textures,
                  global const uchar4 *texels, constant float *linear_from_byte, global const LightInfo *lights,
                  constant EnvironmentInfo *environment, global const Float4 *environment_pixels,
                  global const float *environment_table, global const Float4 *environment_levels,
                  global const ShadowInfo *shadow_infos, global const ShadowView *shadow_views,
                  global const float *shadow_maps, global const ShadowInfo *sure_infos,
                  global const ShadowView *sure_views, global const ShadowTile *sure_tiles,
                  global const ShadowBlock *sure_blocks, global const ShadowRow *sure_rows, uint sure_block_count,
                  global const BvhTriangle *leaf_triangles, global float *kept_verdicts, uint verdict_slots,
                  uint verdicts_stay, global float4 *radiance, global float *shadow_rays, global uint *shadow_slots,
                  global float *reflected_rays, global uint *reflected_slots, global float *transmitted_rays,
                  global uint *transmitted_slots, global uint *counts, constant CameraInfo *cameras, uint view_count,
                  constant Float2 *offsets)
{
  const ShadeInfo *shade = &settings;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  GeometrySources geometry = {positions, normals, tangents};
  ArrivalSources from = {rays, slots, hits, hit_ids, keys, capacity, corners, positions};
  SampleStreams streams = {shadow_rays, shadow_slots, reflected_rays, reflected_slots, capacity, counts};
  CameraSources camera = {cameras, view_count, offsets, shade->first_tile, shade->tile_count, shade->first_sample};
  FloatL zero = FLOATL(0);
#ifdef HAS_SURE_MAPS
  uint judged = 0, waiting = 0;
  SureSources sure = {sure_tiles, sure_blocks, sure_rows, sure_block_count, leaf_triangles};
  KeptVerdicts kept = {kept_verdicts,
                       shade->from_camera && shade->first_batch && !shade->first_light ? verdict_slots : 0,
                       verdicts_stay};
#endif
  const bool begins = shade->from_camera && shade->first_batch;
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  WaveTile tile = {{cameras, (uint2)(0)}, {0, 0}};
  // A work-group's rays are of one tile: the compiler then knows that all have the same camera.
  if (shade->from_camera) tile = wave_tile(&camera, get_group_id(0) * (uint)get_local_size(0) * RAYS_PER_ITEM);
  HitTriangles on;
  bool is_held = false;  // is all of the tile on the triangle that `on` holds?
  TileVerdicts told = {0, 0};
#ifdef HAS_WHOLE_TILES
  const bool is_whole = shade->from_camera && tile_is_whole(hit_ids, begin);
  const uint triangle = hit_ids[begin];
  Float3 seen;
  if (is_whole && triangle == HIT_NONE && begins && !verdict_slots && misses_are_even(&seen, shade, environment) &&
      tile_keep(radiance, shade, &tile.view, begin, seen))
    return;
  is_held = is_whole && triangle != HIT_NONE;
  if (is_held) hit_triangle_hold(&on, &geometry, &attributes, triangle);
#ifdef HAS_SHADOW_MAPS
  if (is_held) told = tile_verdicts(shade, &tile, &on, hits, capacity, begin, shadow_infos, shadow_views, shadow_maps);
#endif
#endif
  for (uint first = begin; first < end; first += LANES) {
    corners_prefetch(corners, hit_ids, first + RAYS_PER_ITEM, ray_count);
    Arrivals in = arrivals_load(&from, shade, &tile, first, ray_count);
    UintL slot = in.slot, id = in.id;
    IntL active = in.t_max > zero;
    IntL hit = active & (id != UINTL(HIT_NONE));
    IntL missed = active & (id == UINTL(HIT_NONE));
    Vec3L direction = in.direction, weight = in.weight;
    FloatL density = FLOATL(INFINITY);
    if (STREAMS_HAVE_DENSITY && !shade->primary) density = LANE_LOAD(rays + RAY_DENSITY * capacity, first);
    Sum sum = {vec3l(zero, zero, zero), zero};
    if (shade->first_batch && any_lane(missed)) {
      Vec3L seen =
          shade_misses(missed, direction, weight, density, shade, environment, environment_pixels, environment_table);
      sum.rgb = select3(missed, seen, sum.rgb);
      if (!begins) radiance_add(radiance, slot, missed, seen);
    }
#ifdef HAS_SURE_MAPS
    uint picture_slot = kept.slots ? wave_picture_slot(&camera, first) : 0;
#endif
    if (!any_lane(hit)) {
      if (begins) sum_keep(radiance, shade, &tile, first, slot, INTL(-1), &sum);
#ifdef HAS_SURE_MAPS
      verdicts_forget(&kept, picture_slot);
#endif
      continue;
    }

    HitPlace at = arrival_place(&in, &from, shade, &tile, first);
    Surface s = surface_load(&on, &geometry, &attributes, id, at.u, at.v, direction, hit, is_held);
    Vec3L to_eye = scale3(unit3(direction), FLOATL(-1));
    FloatL nv = max_lane(fabs(dot3(s.normal, to_eye)), FLOATL(1e-6f));
    Vec3L origin = add3(s.position, s.offset);
#ifdef HAS_BLEND
    if (shade->first_batch) {
      Vec3L through = scale3(weight, FLOATL(1) - s.alpha);
      IntL passes = hit & (max_component3(through) > FLOATL(shade->min_transmitted));
      FloatL left = in.t_max - at.t;
      stream_append_path(passes, sub3(s.position, s.offset), direction, left, through, slot, STREAMS_HAVE_DENSITY,
                         density, transmitted_rays, capacity, transmitted_slots, &counts[STREAM_COUNT_TRANSMITTED]);
    }
    FloatL coverage = shade->primary ? s.alpha * weight.x : zero;
    weight = scale3(weight, s.alpha);
#else
    FloatL coverage = FLOATL(shade->primary ? 1 : 0);
#endif

    IntL lit = hit & !s.unlit;
    SampledSurface sampled = {.surface = &s,
                              .lit = lit,
                              .reflects = INTL(0),
                              .by_map = INTL(0),
                              .origin = origin,
                              .weight = weight,
                              .slot = slot};
#ifdef HAS_LOBES
    if (shade->reflect)
      sampled.reflects = lit & !s.reflectance.mirror & (s.reflectance.roughness <= FLOATL(shade->max_roughness));
#endif
#ifdef HAS_ROUGH_MAPS
    if (shade->reflect)
      sampled.by_map = lit & !s.reflectance.mirror & (s.reflectance.roughness <= FLOATL(shade->map_roughness));
    sampled.reflects = sampled.reflects | sampled.by_map;
#endif
    if (!begins) sum = radiance_load(radiance, slot, hit);
    if (shade->first_batch) {
      sum.rgb = select3(hit, add3(sum.rgb, mul3(surface_own_radiance(&s, shade), weight)), sum.rgb);
      sum.coverage = hit ? sum.coverage + coverage : sum.coverage;
      sum.rgb = environment_light_add(sum.rgb, &sampled, to_eye, nv, shade, environment, environment_pixels,
                                      environment_levels);
    }
#ifdef HAS_SURE_MAPS
    SlotVerdicts of_slots = verdicts_load(&kept, picture_slot, origin, hit);
    IntL streamed = INTL(0);  // a light's ray is: those of later lights wait, as sums keep the lights' order
    IntL shows = !s.reflectance.mirror | (max_component3(s.reflectance.diffuse) > zero);  // light of lights
#endif
    for (uint i = 0; i < shade->light_count; i++) {
      uint number = shade->first_light + i;
      Lighting light = light_arriving(&lights[number], origin);
      IntL reached = lit & (dot3(s.geometric, light.unit) > zero);
#ifdef HAS_SURE_MAPS
      Verdicts verdicts = {INTL(0), INTL(0), INTL(0), UINTL(0), zero};
      const bool is_judged = (shade->casting_lights & shade->judged_lights) >> i & 1 && sure_infos[number].view_count;
      if (is_judged) {
        IntL asks = reached & shows & (dot3(s.normal, light.unit) > zero) & (max_component3(light.irradiance) > zero);
        SureRays of = {origin, light.to_light, light.t_max, id};
        verdicts = kept_judge(&of_slots, &kept, i, &of, &sure_infos[number], sure_views, &sure, asks, &attributes);
        judged += (uint)popcount(
            lane_bits(LANES > 1 ? verdicts.lit | verdicts.dark : (verdicts.lit & !streamed) | verdicts.dark));
        reached = asks & !verdicts.dark;
        if (!any_lane(reached)) continue;
      }
#endif
#if LANES > 1
      if (!any_lane(reached)) continue;
#endif
      Vec3L f = shade->model == LIGHTING_MODEL_PHONG ? brdf_phong(&s.reflectance, s.normal, to_eye, light.unit)
                                                     : brdf_pbr(&s.reflectance, s.normal, to_eye, light.unit);
      Vec3L arrives = mul3(mul3(f, light.irradiance), weight);
      reached = reached & (max_component3(arrives) > zero);
#ifdef HAS_AREA_LIGHTS
      if (shade->area_lights >> i & 1) {
        IntL within = reached & light_point_choose(&light, lights[number].kind, shade, number, slot);
        sum.rgb = select3(within, add3(sum.rgb, arrives), sum.rgb);
        reached = reached & !within & (dot3(s.geometric, light.unit) > zero);
      }
#endif
      if (!(shade->casting_lights >> i & 1)) {
        sum.rgb = select3(reached, add3(sum.rgb, arrives), sum.rgb);
        continue;
      }
#ifdef HAS_SHADOW_MAPS
      global const ShadowInfo *info = &shadow_infos[number];
      if (info->view_count) {
        FloatL fraction = FLOATL((float)(told.lit >> i & 1));
        if (!((told.lit | told.dark) >> i & 1))
          fraction = shadow_lit(info, shadow_views, shadow_maps, origin, s.geometric, id, reached);
        sum.rgb = select3(reached, add3(sum.rgb, scale3(arrives, fraction)), sum.rgb);
        continue;
      }
#endif
#ifdef HAS_SURE_MAPS
      if (is_judged) {
        IntL waits = verdicts.lit & reached & streamed;
        sum.rgb = select3(verdicts.lit & reached & !waits, add3(sum.rgb, arrives), sum.rgb);
        reached = reached & (waits | !verdicts.lit);
#if LANES > 1  // else the judging of what is streamed asks again
        light.t_max = waits ? zero : light.t_max;
        waiting += (uint)popcount(lane_bits(waits));
#endif
      }
      streamed = streamed | reached;
#endif
      stream_append_path(reached, origin, light.to_light, light.t_max, arrives, slot, SHADOWS_HAVE_RECEIVER,
                         LANE_AS_FLOAT(id), shadow_rays + i * RAY_FIELD_COUNT * capacity, capacity,
                         shadow_slots + i * capacity, &counts[i]);
    }
#ifdef HAS_SURE_MAPS
    verdicts_store(&kept, picture_slot, &of_slots, origin);
#endif
    sum_keep(radiance, shade, &tile, first, slot, begins ? INTL(-1) : hit, &sum);
    if (!shade->first_batch) continue;

    if (shade->reflect) {
      Vec3L share =
          shade->model == LIGHTING_MODEL_PHONG ? s.reflectance.specular : fresnel_schlick(s.reflectance.specular, nv);
      Vec3L onward = mul3(share, weight);
      Vec3L mirrored = mirror3(to_eye, s.normal);
      mirrored = select3(dot3(mirrored, s.geometric) > zero, mirrored, mirror3(to_eye, s.geometric));
      IntL spawned = lit & s.reflectance.mirror & (max_component3(onward) > FLOATL(shade->min_weight));
      FloatL source = shade->receivers ? LANE_AS_FLOAT(id | UINTL(RAY_FROM_MIRROR)) : FLOATL(INFINITY);
      FloatL reach = FLOATL(INFINITY);
#ifdef HAS_ROUGH_MAPS
      if (any_lane(sampled.by_map)) {
        Vec3L albedo = mul3(specular_albedo_fit(&s.reflectance, nv), weight), axis = lobe_axis(&s, to_eye);
        mirrored = select3(sampled.by_map & (dot3(axis, s.geometric) > zero), axis, mirrored);
        onward = select3(sampled.by_map, albedo, onward);
        spawned = spawned | (sampled.by_map & (max_component3(albedo) > zero));
        reach = sampled.by_map ? s.reflectance.roughness : reach;
      }
#endif
      stream_append_path(spawned, origin, mirrored, reach, onward, slot, STREAMS_HAVE_DENSITY || shade->receivers,
                         source, reflected_rays, capacity, reflected_slots, &counts[STREAM_COUNT_REFLECTED]);
    }
    environment_light_spawn(&sampled, to_eye, nv, shade, environment, environment_pixels, environment_table,
                            environment_levels, &streams);
  }
#ifdef HAS_SURE_MAPS
  count_add(judged, &counts[STREAM_COUNT_JUDGED]);
  count_add(waiting, &counts[STREAM_COUNT_WAITING]);
#endif
}

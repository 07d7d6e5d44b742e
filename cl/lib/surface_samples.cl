// What a surface does by chance: one sample of the environment's light, one of its own lobes, a few short rays for
// ambient occlusion. Each of them becomes a ray that carries what it would bring.
//
//   The environment's light is the integral of BRDF x radiance x visibility. It is split by lobes, diffuse and
//   specular; for each, a direction chosen by the image's luminance and one chosen as the lobe reflects are weighted
//   against each other by the balance heuristic. Where the surface reflects the scene in its specular lobe, the
//   environment is what is seen past the scene: single-sided back faces are open to that part, and a lobe's sample is a
//   reflected ray, which meets the environment or a surface. All else that comes from the environment is blocked like
//   any light. Directions below the geometric plane bring nothing.
//
//   From  Veach, Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995.

#include "lib/environment_sample.cl"
#include "lib/lobe.cl"
#include "lib/random.cl"
#include "lib/ray_stream.cl"
#include "lib/surface.cl"
#include "shared/shade.h"

// Sets of random numbers of one ray.
#define RANDOM_LIGHT 0u
#define RANDOM_LIGHT_LOBE 1u
#define RANDOM_LOBE 2u
#define RANDOM_OCCLUSION 3u
#define RANDOM_AREA 4u  // and more: one a light

typedef struct RandomSource {
  UintL key, sample;
} RandomSource;

// By pixel of the whole picture, sample, and path; a slot's pixel is as lib/tile.cl has it.
static inline RandomSource random_source(const ShadeInfo *shade, UintL slot)
{
  RandomSource source;
  UintL within = slot % UINTL(TILE_PIXELS), tile = slot / UINTL(TILE_PIXELS);
  UintL turn = divide_lane(tile, UINTL(shade->tile_count));
  source.sample = UINTL(shade->first_sample) + turn;
  tile += UINTL(shade->first_tile) - turn * UINTL(shade->tile_count);
  // As tile_at does.
  UintL bin_tiles = UINTL(BIN_TILES), across = UINTL(shade->tiles_per_row), row = divide_lane(tile, across * bin_tiles);
  tile -= row * across * bin_tiles;
  UintL height = min_uint(bin_tiles, UINTL(shade->tile_rows) - row * bin_tiles);
  UintL column = divide_lane(tile, bin_tiles * height);
  tile -= column * bin_tiles * height;
  UintL width = min_uint(bin_tiles, across - column * bin_tiles), down = divide_lane(tile, width);
  UintL x = (column * bin_tiles + tile - down * width) * UINTL(TILE_SIZE);
  UintL y = (row * bin_tiles + down) * UINTL(TILE_SIZE);
  x += ((within >> UINTL(4)) & UINTL(1)) * UINTL(4) + (within & UINTL(3));
  y += (within >> UINTL(5)) * UINTL(4) + ((within >> UINTL(2)) & UINTL(3));
  source.key = hash_pcg(x + UINTL(shade->crop_x) + hash_pcg(y + UINTL(shade->crop_y) + UINTL(shade->random_key)));
  return source;
}

// Streams that samples go to: segments of shadow rays, and reflected rays.
typedef struct SampleStreams {
  global float *shadow_rays;
  global uint *shadow_slots;
  global float *reflected_rays;
  global uint *reflected_slots;
  uint capacity;
  global uint *counts;
} SampleStreams;

// A surface as its samples need it.
typedef struct SampledSurface {
  const Surface *surface;
  IntL lit;       // lanes that light can reach
  IntL reflects;  // lanes whose specular lobe sees the scene
  IntL by_map;    // of these, lanes for which maps answer: no samples of it
  Vec3L origin;
  Vec3L view;    // to the eye, turned to the side of the normal
  Vec3L weight;  // throughput
  UintL slot;
  RandomSource random;
  FloatL to_specular;  // share of the lobe samples that go to the specular lobe
} SampledSurface;

// Samples go to the lobes as light from everywhere would.
static inline FloatL specular_share(const Reflectance *r, FloatL nv)
{
  FloatL diffuse = luminance3(diffuse_albedo_pbr(r, nv));
  FloatL specular = r->mirror ? FLOATL(0) : luminance3(specular_albedo_fit(r, nv));
  FloatL sum = diffuse + specular;
  return sum > FLOATL(0) ? specular / sum : FLOATL(0);
}

// To segment `which` of the environment's.
static inline void environment_ray_append(const SampledSurface *at, IntL mask, Vec3L direction, FloatL t_max,
                                          Vec3L brings, uint which, const ShadeInfo *shade, const SampleStreams *to)
{
  uint segment = shade->environment_segment + which;
  IntL up = dot3(at->surface->geometric, direction) > FLOATL(0);
  stream_append(mask & up & (max_component3(brings) > FLOATL(0)), at->origin, direction, t_max, brings, at->slot,
                to->shadow_rays + segment * RAY_FIELD_COUNT * to->capacity, to->capacity,
                to->shadow_slots + segment * to->capacity, &to->counts[STREAM_COUNT_ENVIRONMENT + which]);
}

// A direction chosen by the image's luminance.
static inline void light_sample_spawn(const SampledSurface *at, const ShadeInfo *shade,
                                      constant EnvironmentInfo *environment, global const Float4 *pixels,
                                      global const float *table, const SampleStreams *to)
{
  const Surface *s = at->surface;
  FloatL x, y, zero = FLOATL(0), one = FLOATL(1);
  random_point(at->random.key + UINTL(RANDOM_LIGHT), at->random.sample, &x, &y);
  EnvironmentSample light = environment_sample(environment, pixels, table, x, y, at->lit);
  PbrTerms terms = brdf_pbr_terms(&s->reflectance, s->normal, at->view, light.direction);
  IntL reached = at->lit & (terms.nl > zero) & (light.density > zero);
  if (!any_lane(reached)) return;
  FloatL diffuse_density = (one - at->to_specular) * terms.nl * FLOATL(INV_PI);
  FloatL specular_density = at->to_specular * terms.specular_density;
  Vec3L arrives = scale3(mul3(light.radiance, at->weight), terms.nl);
  Vec3L diffuse = mul3(terms.diffuse, scale3(arrives, s->occlusion / (diffuse_density + light.density)));
  Vec3L specular = mul3(terms.specular, scale3(arrives, one / (specular_density + light.density)));
  specular = select3(at->by_map, vec3l(zero, zero, zero), specular);
  IntL apart = reached & at->reflects & !at->by_map;
  FloatL far = FLOATL(INFINITY);
  if (shade->environment_light != ENVIRONMENT_BY_SAMPLES) {
    environment_ray_append(at, reached, light.direction, far, specular, shade->environment_open, shade, to);
    return;
  }
  if (any_lane(apart)) {
    // The two parts are blocked by different sides: a ray for one of them, in proportion.
    FloatL share = luminance3(specular), sum = share + luminance3(diffuse);
    share = sum > zero ? share / sum : zero;
    random_point(at->random.key + UINTL(RANDOM_LIGHT_LOBE), at->random.sample, &x, &y);
    IntL chosen = x < share;
    environment_ray_append(at, apart & chosen, light.direction, far, scale3(specular, one / share),
                           shade->environment_open, shade, to);
    diffuse = select3(apart, scale3(diffuse, chosen ? zero : one / (one - share)), diffuse);
    specular = select3(apart, vec3l(zero, zero, zero), specular);
  }
  environment_ray_append(at, reached, light.direction, far, add3(diffuse, specular), ENVIRONMENT_RAYS_IMAGE, shade, to);
}

// A direction chosen as the surface reflects: a reflected ray, or a ray that the environment's light comes along.
static inline void lobe_sample_spawn(const SampledSurface *at, const ShadeInfo *shade,
                                     constant EnvironmentInfo *environment, global const Float4 *pixels,
                                     global const float *table, const SampleStreams *to)
{
  const Surface *s = at->surface;
  FloatL x, y, zero = FLOATL(0), one = FLOATL(1);
  random_point(at->random.key + UINTL(RANDOM_LOBE), at->random.sample, &x, &y);
  IntL is_specular = x < at->to_specular;
  FloatL share = is_specular ? at->to_specular : one - at->to_specular;
  x = min_lane((is_specular ? x : x - at->to_specular) / share, FLOATL(0.99999994f));
  LobeSample sample = {vec3l(zero, zero, zero), vec3l(zero, zero, zero), one};
  if (any_lane(at->lit & is_specular)) sample = lobe_sample_specular(&s->reflectance, s->normal, at->view, x, y);
  if (any_lane(at->lit & !is_specular)) {
    LobeSample diffuse = lobe_sample_diffuse(&s->reflectance, s->normal, at->view, x, y);
    sample.direction = select3(is_specular, sample.direction, diffuse.direction);
    sample.weight = select3(is_specular, sample.weight, scale3(diffuse.weight, s->occlusion));
    sample.density = is_specular ? sample.density : diffuse.density;
  }
  Vec3L brings = mul3(sample.weight, at->weight);
  IntL reflected = at->lit & is_specular & at->reflects & (dot3(s->geometric, sample.direction) > zero);
  Vec3L onward = scale3(brings, one / share);
  stream_append_path(reflected & (max_component3(onward) > FLOATL(shade->min_weight)), at->origin, sample.direction,
                     FLOATL(INFINITY), onward, at->slot, true, share * sample.density, to->reflected_rays, to->capacity,
                     to->reflected_slots, &to->counts[STREAM_COUNT_REFLECTED]);

  IntL open = at->lit & !(is_specular & at->reflects);
  if (shade->environment_light != ENVIRONMENT_BY_SAMPLES || !any_lane(open)) return;
  ImagePlace place;
  Vec3L radiance = environment_radiance_at(environment, pixels, sample.direction, open, &place);
  FloatL by_light = zero;
  if (shade->environment_table) by_light = environment_density(environment, table, sample.direction, radiance, &place);
  brings = scale3(mul3(brings, radiance), one / (share + by_light / sample.density));
  environment_ray_append(at, open, sample.direction, FLOATL(INFINITY), brings, ENVIRONMENT_RAYS_LOBE, shade, to);
}

// What an unoccluded environment sends to the eye, in equal parts on OCCLUSION_RAYS short rays by the cosine.
static inline void occlusion_rays_spawn(const SampledSurface *at, Vec3L light, const ShadeInfo *shade,
                                        const SampleStreams *to)
{
  Vec3L brings = scale3(mul3(light, at->weight), FLOATL(1.0f / OCCLUSION_RAYS));
  for (uint i = 0; i < OCCLUSION_RAYS; i++) {
    FloatL x, y;
    random_point(at->random.key + UINTL(RANDOM_OCCLUSION), at->random.sample * UINTL(OCCLUSION_RAYS) + UINTL(i), &x,
                 &y);
    Vec3L direction = cosine_sample(at->surface->normal, x, y);
    environment_ray_append(at, at->lit, direction, FLOATL(shade->occlusion_radius_m), brings, i, shade, to);
  }
}

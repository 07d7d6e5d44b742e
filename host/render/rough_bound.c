#include "render/rough_bound.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/cube_error.h"
#include "render/reflector_cube.h"
#include "shared/stream.h"

static const double threshold = 2.0 / 255;

static Vec3 wide(Float3 v) { return vec3((double)v.x, (double)v.y, (double)v.z); }

// ---- one probe ------------------------------------------------------------------------------------------------------

// The axis ray, the samples of its lobe, and what is right of them.
typedef struct RoughProbe {
  const ReflectionSight *axis;
  const ReflectionSight *samples[ROUGH_SAMPLES];
  double radiance[ROUGH_SAMPLES][3];  // that came along a sample, by channel; one of the samples that is a lobe's
  uint32_t count;                     // of these
  double direct[3], right[3];
  double under;  // share of the map's lobe that is under the horizon
} RoughProbe;

static bool probe_make(RoughProbe *out, const ReflectionSight *axis, const ReflectionSight *first, uint32_t stride)
{
  *out = (RoughProbe){.axis = axis};
  for (uint32_t s = 0; s < ROUGH_SAMPLES; s++) {
    const ReflectionSight *sample = &first[(size_t)s * stride];
    const bool lobe = sample->is_lobe && sample->density > 0;
    for (int c = 0; c < 3; c++) {
      const double direct = (double)(lobe ? sample->direct : sample->radiance)[c], all = (double)sample->radiance[c];
      out->direct[c] += direct / ROUGH_SAMPLES;
      out->right[c] += all / ROUGH_SAMPLES;
      if (lobe) out->radiance[out->count][c] = sample->weight[c] > 0 ? (all - direct) / (double)sample->weight[c] : 0;
    }
    if (lobe) out->samples[out->count++] = sample;
  }
  return out->count >= ROUGH_LEAST;
}

// What a map's lobe is, from the cube's centre.
typedef struct MapLobe {
  Vec3 axis, center;
  double alpha;
  bool near;  // what is met has a place: else all of it is infinitely far away
} MapLobe;

static double lobe_kernel(double cosine, double alpha)
{
  double d = 1 + (alpha * alpha - 1) * (1 + cosine) / 2;
  return cosine > 0 ? cosine / (d * d) : 0;
}

// Means of the samples' radiance by a lobe of that alpha, their standard errors; returns how many samples' worth it is.
static double lobe_mean(double mean[3], double error[3], const RoughProbe *probe, const MapLobe *lobe, double alpha)
{
  double weights[ROUGH_SAMPLES], sum = 0, squares = 0;
  for (uint32_t j = 0; j < probe->count; j++) {
    const ReflectionSight *sample = probe->samples[j];
    Vec3 seen = sample->direction;
    double ratio = 1;
    if (isfinite(sample->distance)) {
      Vec3 way = vec3_scale(sample->direction, sample->distance);
      Vec3 met = vec3_sub(vec3_add(sample->origin, way), lobe->center);
      ratio = vec3_dot(way, way) / fmax(vec3_dot(met, met), 1e-30);
      seen = met;
    }
    double cosine = vec3_dot(vec3_unit_or(seen, lobe->axis), lobe->axis);
    weights[j] = lobe_kernel(cosine, alpha) * ratio / (double)sample->density;
    sum += weights[j];
    squares += weights[j] * weights[j];
  }
  for (int c = 0; c < 3; c++) {
    mean[c] = error[c] = 0;
    for (uint32_t j = 0; j < probe->count && sum > 0; j++) mean[c] += weights[j] / sum * probe->radiance[j][c];
    for (uint32_t j = 0; j < probe->count && sum > 0; j++) {
      double off = weights[j] / sum * (probe->radiance[j][c] - mean[c]);
      error[c] += off * off;
    }
    error[c] = sqrt(error[c]);
  }
  return squares > 0 ? sum * sum / squares : 0;
}

// The same by the two levels between which a map interpolates; none is narrower than a texel.
static double levels_mean(double mean[3], double error[3], const RoughProbe *probe, const MapLobe *lobe, uint32_t size)
{
  const uint32_t last = cube_level_count(size) - 1;
  const double level = fmax(-log2(fmin(lobe->alpha, 1)), 0), whole = fmin(floor(level), last);
  const bool beyond = level >= last;
  const double share = beyond ? 1 - lobe->alpha / exp2(-whole) : level - whole;
  const double texel = 0.5 * cube_texel_rad(size);
  double coarse[3], fine[3], coarse_error[3], fine_error[3];
  double alphas[2] = {exp2(-whole), beyond ? 0 : exp2(-whole - 1)};
  double worth = lobe_mean(coarse, coarse_error, probe, lobe, hypot(alphas[0], texel));
  double other = lobe_mean(fine, fine_error, probe, lobe, hypot(alphas[1], texel));
  for (int c = 0; c < 3; c++) {
    mean[c] = coarse[c] + share * (fine[c] - coarse[c]);
    error[c] = coarse_error[c] + share * (fine_error[c] - coarse_error[c]);
  }
  return share < 1 - 1e-3 ? fmin(worth, other) : other;
}

// The sample next to the lobe's axis.
static const ReflectionSight *axis_sample(const RoughProbe *probe)
{
  const ReflectionSight *best = probe->samples[0];
  for (uint32_t j = 1; j < probe->count; j++)
    if (vec3_dot(probe->samples[j]->direction, probe->axis->direction) >
        vec3_dot(best->direction, probe->axis->direction))
      best = probe->samples[j];
  return best;
}

static MapLobe map_lobe(const RoughProbe *probe, const CubeInfo *cube, int rung)
{
  const Vec3 axis = vec3_unit_or(probe->axis->direction, vec3(0, 0, 1)), center = wide(cube->center);
  const Vec3 at = vec3_sub(probe->axis->origin, center);
  MapLobe lobe = {axis, center, pow((double)probe->axis->roughness, 2), false};
  Vec3 end = axis;
  bool ends = false;
  if (rung == BOUND_BOX) {
    end = cube_box_end(cube, at, axis);
    ends = vec3_length(vec3_sub(end, axis)) > 0;
  }
  if (rung == BOUND_IMPOSTOR) {
    const ReflectionSight *sample = axis_sample(probe);
    ends = isfinite(sample->distance);
    if (ends) end = vec3_add(at, vec3_scale(axis, sample->distance * vec3_length(sample->direction)));
  }
  lobe.axis = vec3_unit_or(end, axis);
  if (ends) lobe.alpha *= vec3_length(vec3_sub(end, at)) / fmax(vec3_length(end), 1e-30);
  lobe.alpha = fmin(lobe.alpha, 1);
  return lobe;
}

static bool differs(double shown, double right, double error, double scale)
{
  double low = displayed(scale * (shown - error)), high = displayed(scale * (shown + error));
  double is = displayed(scale * right);
  return fmax(high - is, is - low) > threshold;
}

// Is the pixel wrong by a rung?
static bool probe_is_wrong(const RoughProbe *probe, const CubeInfo *cube, int rung, double scale)
{
  double mean[3] = {0}, error[3] = {0};
  if (rung == BOUND_ENVIRONMENT) {
    for (int c = 0; c < 3; c++)
      if (differs((double)probe->axis->radiance[c], probe->right[c], 0, scale)) return true;
    return false;
  }
  const MapLobe lobe = map_lobe(probe, cube, rung);
  const double worth = levels_mean(mean, error, probe, &lobe, cube->size);
  for (int c = 0; c < 3; c++) {
    const double weight = (double)probe->axis->weight[c];
    if (worth < ROUGH_LEAST && weight * scale > threshold) return true;
    double off = weight * (error[c] + probe->under * mean[c]);
    if (differs(probe->direct[c] + weight * mean[c], probe->right[c], off, scale)) return true;
  }
  return false;
}

// Share of a lobe about the axis that is under the surface, whose normal is halfway to the eye.
static double lobe_under(const RoughProbe *probe, Vec3 to_eye)
{
  enum { RINGS = 16, TURNS = 8 };
  const Vec3 axis = vec3_unit_or(probe->axis->direction, to_eye), normal = vec3_unit_or(vec3_add(axis, to_eye), axis);
  const Vec3 other = fabs(axis.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
  const Vec3 across = vec3_unit_or(vec3_cross(other, axis), other), down = vec3_cross(axis, across);
  const double alpha = pow((double)probe->axis->roughness, 2);
  double all = 0, under = 0;
  for (int i = 0; i < RINGS * TURNS; i++) {
    double x = (i / TURNS + 0.5) / RINGS, cosine2 = (1 - x) / (1 + (alpha * alpha - 1) * x), c = 2 * cosine2 - 1;
    if (c <= 0) continue;
    double s = sqrt(1 - c * c), turn = 2 * M_PI * (i % TURNS + 0.5) / TURNS;
    Vec3 d =
        vec3_add(vec3_scale(axis, c), vec3_add(vec3_scale(across, s * cos(turn)), vec3_scale(down, s * sin(turn))));
    all += c;
    if (vec3_dot(d, normal) < 0) under += c;
  }
  return all > 0 ? under / all : 0;
}

// ---- all of them ----------------------------------------------------------------------------------------------------

// The frame's request for a small picture of every surface's reflection: of rays along lobes, or of their axes.
static FrameRequest probe_request(const Frame *frame, ReflectionSights *sights, uint32_t block_px)
{
  FrameRequest request = frame->request;
  Plan *plan = &request.plan;
  request.sights = sights;
  request.block_px = block_px;
  request.samples = sights->axes ? 1 : ROUGH_SAMPLES;
  request.aovs = AOV_SET_NONE;
  request.progress = NULL;
  plan->primary = PRIMARY_RAYS;
  if (plan_uses_shadows(plan, SHADOW_SET(SHADOWS_HYBRID)))
    plan->shadow_methods ^= SHADOW_SET(SHADOWS_HYBRID) | SHADOW_SET(SHADOWS_RAYS);
  plan->max_roughness = plan->exact_roughness;
  plan->rough_by_maps = sights->axes;
  plan->reflections = plan->deep_reflections = sights->axes ? REFLECTIONS_ENVIRONMENT : REFLECTIONS_RAYS;
  plan->lobes = plan->lobes_alone = !sights->axes;
  if (sights->axes && plan->environment_light == ENVIRONMENT_LIGHT_SAMPLED)
    plan->environment_light = ENVIRONMENT_LIGHT_SH;
  return request;
}

static Status sights_render(ReflectionSights *out, uint32_t *pixels, uint64_t *probes, const Frame *frame,
                            uint32_t block_px, Log *log)
{
  Status status = STATUS_OK;
  Frame probing = {0};
  float offsets[ROUGH_SAMPLES][2];
  const bool axes = out->axes;
  FrameRequest request = probe_request(frame, out, block_px);
  for (int i = 0; i < ROUGH_SAMPLES; i++) offsets[i][0] = offsets[i][1] = 0.5f / (float)block_px;
  TRY(frame_make(&probing, frame->device, frame->scene, &request, log));
  TRY(buffer_write(frame->device, &probing.camera.offsets, offsets, request.samples * sizeof *offsets, log));
  TRY(reflection_sights_make(out, probing.capacity, log));
  out->axes = axes;
  TRY(frame_render(&probing, log));
  const CameraInfo *blocks = &probing.camera.info;
  *pixels = blocks->tiles_per_row * ((blocks->height + TILE_SIZE - 1) / TILE_SIZE) * TILE_PIXELS;
  *probes = (uint64_t)blocks->width * blocks->height;

done:
  frame_free(&probing);
  return status;
}

// Cubes as the frame has them, or as it would have them of what the probes see, by object.
static void cubes_guess(CubeInfo *cubes, const Frame *frame, const ReflectionSights *axes, uint32_t pixels,
                        const uint32_t *starts, uint32_t block_px)
{
  const uint32_t objects = frame->scene->object_count;
  Reflector *reflectors = calloc((size_t)objects + 1, sizeof *reflectors);
  if (!reflectors) return;
  for (uint32_t i = 0; i < pixels; i++) {
    const ReflectionSight *axis = &axes->sights[i];
    if (!axis->is_lobe) continue;
    const uint32_t object = object_of_triangle(starts, objects, axis->triangle);
    const Vec3 eye = wide(frame->camera.info.position);
    reflector_see_rough(&reflectors[object], object, axis->roughness,
                        &(RoughSight){axis->origin, vec3_sub(axis->origin, eye)});
  }
  for (uint32_t o = 0; o < objects; o++)
    if (reflectors[o].rough_pixels) cubes[o] = reflector_rough_cube(frame, &reflectors[o], block_px);
  free(reflectors);
}

// The rung that answers for rough surfaces: with lists the impostor; by the exact ones they see the environment alone,
// where their lobes are not sampled.
static int rung_of_lobes(int rung)
{
  if (rung <= BOUND_IMPOSTOR) return rung;
  return rung == BOUND_PLANAR || rung == BOUND_HYBRID ? BOUND_ENVIRONMENT : BOUND_IMPOSTOR;
}

static void probes_judge(BoundSums *sums, const ReflectionSights *axes, const ReflectionSights *lobes, uint32_t pixels,
                         const CubeInfo *cubes, const uint32_t *starts, const Frame *frame, double worth, double scale)
{
  const Vec3 eye = wide(frame->camera.info.position);
  for (uint32_t i = 0; i < pixels; i++) {
    RoughProbe probe;
    if (!axes->sights[i].is_lobe) continue;
    const uint32_t object = object_of_triangle(starts, frame->scene->object_count, axes->sights[i].triangle);
    const bool known = probe_make(&probe, &axes->sights[i], &lobes->sights[i], pixels);
    probe.under = lobe_under(&probe, vec3_unit_or(vec3_sub(eye, axes->sights[i].origin), vec3(0, 0, 1)));
    sums[object].shown += worth;
    for (int rung = 0; rung < BOUND_RUNGS; rung++) {
      const double wrong = known && !probe_is_wrong(&probe, &cubes[object], rung_of_lobes(rung), scale) ? 0 : worth;
      sums[object].wrong[rung] += wrong;
      sums[object].squares[rung] += wrong * wrong;
    }
  }
}

Status rough_bound_add(BoundSums *sums, const Frame *frame, const uint32_t *starts, double probes, float scale,
                       Log *log)
{
  Status status = STATUS_OK;
  const CameraInfo *camera = &frame->camera.info;
  const Plan *plan = &frame->request.plan;
  ReflectionSights axes = {.axes = true}, lobes = {0};
  uint32_t block_px = (uint32_t)ceil(sqrt((double)camera->width * camera->height / ROUGH_PROBES)), pixels = 0;
  uint64_t count = 0;
  CubeInfo *cubes = NULL;
  bool any = false;
  if (!(plan->exact_roughness > 0) || plan_samples_lobes(plan)) return STATUS_OK;
  if (block_px < 1) block_px = 1;
  cubes = calloc((size_t)frame->scene->object_count + 1, sizeof *cubes);
  if (!cubes) return log_no_memory(log, "reflection bound");
  TRY(sights_render(&axes, &pixels, &count, frame, block_px, log));
  for (uint32_t i = 0; i < pixels; i++) any |= axes.sights[i].is_lobe;
  if (!any) goto done;
  TRY(sights_render(&lobes, &pixels, &count, frame, block_px, log));
  cubes_guess(cubes, frame, &axes, pixels, starts, block_px);
  probes_judge(sums, &axes, &lobes, pixels, cubes, starts, frame, probes / (double)count, (double)scale);

done:
  reflection_sights_free(&axes);
  reflection_sights_free(&lobes);
  free(cubes);
  return status;
}

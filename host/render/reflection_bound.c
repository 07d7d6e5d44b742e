#include "render/reflection_bound.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/cube_error.h"
#include "render/reflectors.h"
#include "render/rough_bound.h"
#include "shared/stream.h"

enum { NEIGHBOURS = 2, SAMPLES = 1 + NEIGHBOURS };

static const double threshold = 2.0 / 255, normal_99 = 2.576, bound_factor = 1.15;

// Of a texel, by which an edge in it is smeared: all of it across, edges of all directions counted to the right and
// down.
static const double texel_share = 0.8;

// Of what an outline smears, by what the impostor does not tell and trace: found by trial.
static const double outline_share = 0.006;

// ---- one probe ------------------------------------------------------------------------------------------------------

static Vec3 wide(Float3 v) { return vec3((double)v.x, (double)v.y, (double)v.z); }

static double box_end(double at, double direction, double low, double high)
{
  return direction > 0 ? (high - at) / direction : direction < 0 ? (low - at) / direction : INFINITY;
}

Vec3 cube_box_end(const CubeInfo *cube, Vec3 at, Vec3 direction)
{
  Vec3 low = wide(cube->low), high = wide(cube->high);
  double t = fmin(box_end(at.x, direction.x, low.x, high.x), box_end(at.y, direction.y, low.y, high.y));
  t = fmin(t, box_end(at.z, direction.z, low.z, high.z));
  return t > 0 && isfinite(t) ? vec3_add(at, vec3_scale(direction, t)) : direction;
}

// What a map shows of a ray and what the ray meets, as unit directions from the cube's centre.
typedef struct SightErrors {
  Vec3 met, shown[BOUND_RUNGS];
  double distance;  // of what it meets
} SightErrors;

static SightErrors sight_errors(const ReflectionSight *sight, const CubeInfo *cube)
{
  const Vec3 up = {0, 0, 1};
  Vec3 direction = vec3_unit_or(sight->direction, up), at = vec3_sub(sight->origin, wide(cube->center));
  bool open = isinf(sight->distance);
  Vec3 met = open ? direction : vec3_add(at, vec3_scale(sight->direction, sight->distance));
  SightErrors errors = {.met = vec3_unit_or(met, direction), .distance = open ? INFINITY : vec3_length(met)};
  errors.shown[BOUND_CUBE] = direction;
  errors.shown[BOUND_BOX] = vec3_unit_or(cube_box_end(cube, at, direction), direction);
  errors.shown[BOUND_IMPOSTOR] = errors.met;
  return errors;
}

double displayed(double linear)
{
  double value = fmin(fmax(linear, 0), 1);
  return value <= 0.0031308 ? 12.92 * value : 1.055 * pow(value, 1 / 2.4) - 0.055;
}

static double change_shown(const ReflectionSight *a, const ReflectionSight *b, double scale)
{
  double most = 0;
  for (int c = 0; c < 3; c++)
    most = fmax(most, fabs(displayed(scale * (double)a->radiance[c]) - displayed(scale * (double)b->radiance[c])));
  return most;
}

// Pixels to the right and down by which what is `shown` lies off, where one pixel to the right is `right`, one down
// `down` off.
static void shift_solve(double out[NEIGHBOURS], Vec3 shown, Vec3 right, Vec3 down)
{
  double rr = vec3_dot(right, right), dd = vec3_dot(down, down), rd = vec3_dot(right, down);
  double r = vec3_dot(right, shown), d = vec3_dot(down, shown), determinant = fmax(rr * dd - rd * rd, 1e-30);
  out[0] = fabs(r * dd - d * rd) / determinant;
  out[1] = fabs(d * rr - r * rd) / determinant;
}

// How far a map shows what a sight meets off, to each neighbour; INFINITY: it cannot be told.
static void sight_shift(double out[NEIGHBOURS], const SightErrors *errors, int rung, const Vec3 steps[NEIGHBOURS],
                        double texel_rad)
{
  shift_solve(out, vec3_sub(errors->shown[rung], errors->met), steps[0], steps[1]);
  for (int k = 0; k < NEIGHBOURS; k++) out[k] += texel_share * texel_rad / vec3_length(steps[k]);
}

// Pixels that a probe finds wrong, by rung: an edge beside it sweeps more than one.
static void probe_wrong(double out[BOUND_RUNGS], const ReflectionSight *probe,
                        const ReflectionSight *beside[NEIGHBOURS], const CubeInfo *cube, double scale)
{
  SightErrors own = sight_errors(probe, cube), theirs[NEIGHBOURS];
  Vec3 direction = own.shown[BOUND_CUBE], steps[NEIGHBOURS];
  double change[NEIGHBOURS] = {0}, texel_rad = cube_texel_rad(cube->size);
  memset(out, 0, BOUND_RUNGS * sizeof *out);
  out[BOUND_ENVIRONMENT] = isfinite(probe->distance);
  if (!beside[0] && !beside[1]) return;
  for (int k = 0; k < NEIGHBOURS; k++) {
    if (!beside[k]) continue;
    theirs[k] = sight_errors(beside[k], cube);
    change[k] = change_shown(probe, beside[k], scale);
    steps[k] = vec3_sub(theirs[k].shown[BOUND_CUBE], direction);
  }
  // At the reflector's rim: as much the other way.
  for (int k = 0; k < NEIGHBOURS; k++)
    if (!beside[k]) steps[k] = vec3_cross(direction, steps[1 - k]);
  for (int rung = BOUND_CUBE; rung < BOUND_RUNGS; rung++) {
    double shift[NEIGHBOURS], other[NEIGHBOURS], edges = 0, smooth = 0;
    sight_shift(shift, &own, rung, steps, texel_rad);
    for (int k = 0; k < NEIGHBOURS; k++) {
      if (!beside[k]) continue;
      bool outline = theirs[k].distance < 0.8 * own.distance || own.distance < 0.8 * theirs[k].distance;
      double share = rung == BOUND_IMPOSTOR && outline ? outline_share : 1;
      sight_shift(other, &theirs[k], rung, steps, texel_rad);
      if (change[k] > threshold)
        edges += share * fmax(shift[k], other[k]);
      else
        smooth += change[k] * shift[k];
    }
    out[rung] = edges > 0 ? edges : smooth > threshold;
  }
}

// ---- all of them ----------------------------------------------------------------------------------------------------

// The frame's request for a small picture by rays.
static FrameRequest sight_request(const Frame *frame, uint32_t block_px, ReflectionSights *sights)
{
  FrameRequest request = frame->request;
  request.sights = sights;
  request.block_px = block_px;
  request.samples = SAMPLES;
  request.aovs = AOV_SET_NONE;
  request.progress = NULL;
  request.plan.primary = PRIMARY_RAYS;
  request.plan.reflections = REFLECTIONS_RAYS;
  request.plan.deep_reflections = REFLECTIONS_RAYS;
  return request;
}

// The middle of a block's first pixel, and those to the right of it and below.
static void sight_offsets(float out[SAMPLES][2], uint32_t block_px)
{
  float half = 0.5f / (float)block_px;
  const float offsets[SAMPLES][2] = {{half, half}, {3 * half, half}, {half, 3 * half}};
  memcpy(out, offsets, sizeof offsets);
}

// What the sums of probes say of a whole in which `count` of them were sent out.
static BoundShare share_of(double wrong, double squares, double most, double count)
{
  double expected = fmin(wrong / count, most), error = sqrt(fmax(squares / count - expected * expected, 0) / count);
  return (BoundShare){
      expected, fmin(bound_factor * (expected + normal_99 * error), fmin(1, most + normal_99 * sqrt(most / count)))};
}

static void sums_add(BoundSums *sums, const double wrong[BOUND_RUNGS])
{
  sums->shown++;
  for (int rung = 0; rung < BOUND_RUNGS; rung++) {
    sums->wrong[rung] += wrong[rung];
    sums->squares[rung] += wrong[rung] * wrong[rung];
  }
}

// `cubes` and `sums`: [object_count].
static void probes_judge(BoundSums *sums, const ReflectionSights *sights, uint32_t pixels, const CubeInfo *cubes,
                         const uint32_t *starts, uint32_t objects, double scale)
{
  for (uint32_t i = 0; i < pixels; i++) {
    const ReflectionSight *probe = &sights->sights[i], *beside[NEIGHBOURS];
    if (!probe->is_reflected) continue;
    uint32_t object = object_of_triangle(starts, objects, probe->triangle);
    for (uint32_t k = 0; k < NEIGHBOURS; k++) {
      const ReflectionSight *there = &sights->sights[i + (k + 1) * pixels];
      bool same = there->is_reflected && object_of_triangle(starts, objects, there->triangle) == object;
      beside[k] = same ? there : NULL;
    }
    double wrong[BOUND_RUNGS];
    probe_wrong(wrong, probe, beside, &cubes[object], scale);
    sums_add(&sums[object], wrong);
  }
}

static void cubes_guess(CubeInfo *cubes, const Frame *frame, const ReflectionSights *sights, uint32_t pixels,
                        const uint32_t *starts, uint32_t block_px)
{
  uint32_t objects = frame->scene->object_count;
  for (uint32_t i = 0; i < pixels; i++)
    if (sights->sights[i].is_reflected) cubes[object_of_triangle(starts, objects, sights->sights[i].triangle)].size++;
  for (uint32_t o = 0; o < objects; o++)
    if (cubes[o].size) cubes[o] = reflector_cube(frame, o, (double)cubes[o].size * block_px * block_px);
}

static void bound_fill(ReflectionBound *bound, const BoundSums *sums, uint32_t objects)
{
  double count = (double)bound->probes;
  BoundSums all = {0};
  for (uint32_t o = 0; o < objects; o++) {
    if (!(sums[o].shown > 0)) continue;
    ReflectorBound *reflector = &bound->reflectors[bound->count++];
    *reflector = (ReflectorBound){.object = o, .share = sums[o].shown / count};
    all.shown += sums[o].shown;
    for (int rung = 0; rung < BOUND_RUNGS; rung++) {
      reflector->rungs[rung] = share_of(sums[o].wrong[rung], sums[o].squares[rung], reflector->share, count);
      all.wrong[rung] += reflector->rungs[rung].expected * count;
      all.squares[rung] += sums[o].squares[rung];
    }
  }
  for (int rung = 0; rung < BOUND_RUNGS; rung++)
    bound->rungs[rung] = share_of(all.wrong[rung], all.squares[rung], all.shown / count, count);
}

Status reflection_bound_make(ReflectionBound *out, const Frame *frame, float scale, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  const CameraInfo *camera = &frame->camera.info;
  const uint32_t objects = frame->scene->object_count;
  uint32_t block_px = (uint32_t)ceil(sqrt((double)camera->width * camera->height / BOUND_PROBES));
  if (block_px < 2) block_px = 2;  // a probe's neighbours are its own
  Frame probing = {0};
  ReflectionSights sights = {0};
  float offsets[SAMPLES][2];
  FrameRequest request = sight_request(frame, block_px, &sights);
  ReflectionBound bound = {.reflectors = calloc(objects + 1, sizeof *bound.reflectors)};
  BoundSums *sums = calloc(objects + 1, sizeof *sums);
  CubeInfo *cubes = calloc(objects + 1, sizeof *cubes);
  uint32_t *starts = malloc((objects + 1) * sizeof *starts);
  if (!bound.reflectors || !sums || !cubes || !starts) {
    status = log_no_memory(log, "reflection bound");
    goto done;
  }
  sight_offsets(offsets, block_px);
  TRY(buffer_read(device, &frame->scene->object_starts, starts, (objects + 1) * sizeof *starts, log));
  TRY(frame_make(&probing, device, frame->scene, &request, log));
  TRY(buffer_write(device, &probing.camera.offsets, offsets, sizeof offsets, log));
  TRY(reflection_sights_make(&sights, probing.capacity, log));
  TRY(frame_render(&probing, log));
  const CameraInfo *blocks = &probing.camera.info;
  uint32_t pixels = blocks->tiles_per_row * ((blocks->height + TILE_SIZE - 1) / TILE_SIZE) * TILE_PIXELS;
  bound.probes = (uint64_t)blocks->width * blocks->height;
  cubes_guess(cubes, frame, &sights, pixels, starts, block_px);
  probes_judge(sums, &sights, pixels, cubes, starts, objects, (double)scale);
  TRY(rough_bound_add(sums, frame, starts, (double)bound.probes, scale, log));
  bound_fill(&bound, sums, objects);
  *out = bound;
  bound = (ReflectionBound){0};

done:
  reflection_bound_free(&bound);
  reflection_sights_free(&sights);
  frame_free(&probing);
  free(sums);
  free(cubes);
  free(starts);
  return status;
}

void reflection_bound_free(ReflectionBound *bound)
{
  free(bound->reflectors);
  *bound = (ReflectionBound){0};
}

#include "render/reflection_bound.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/cube_error.h"
#include "render/list_bound.h"
#include "render/reflector_cube.h"
#include "render/rough_bound.h"
#include "shared/stream.h"

enum { NEIGHBOURS = 2, SAMPLES = 1 + 2 * NEIGHBOURS };

static const double threshold = 2.0 / 255, normal_99 = 2.576, bound_factor = 1.3;

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

// A probe and the sights beside it: the next pixels', and the next blocks' first. NULL where they show another
// reflector, or none.
typedef struct ProbeSights {
  const ReflectionSight *own, *beside[NEIGHBOURS], *across[NEIGHBOURS];
  double block_px;
  bool far;
} ProbeSights;

// What lies between a probe and the next pixel, or with `far` the next block, if that shows the same reflector. An edge
// between blocks is one for each of the block's pixels in a row; what grows as steadily as from pixel to pixel is none.
static ProbeEdge probe_edge(const ReflectionSight **other, const ProbeSights *sights, int k, double scale)
{
  ProbeEdge edge = {.is_there = sights->beside[k]};
  if (!edge.is_there) return edge;
  *other = sights->beside[k];
  edge.change = change_shown(sights->own, *other, scale);
  edge.weight = edge.change > threshold;
  if (!sights->far || !sights->across[k]) return edge;
  double steady = edge.weight > 0 ? 0 : 2 * sights->block_px * edge.change;
  *other = sights->across[k];
  edge.weight = change_shown(sights->own, *other, scale) > fmax(threshold, steady) ? 1 / sights->block_px : 0;
  edge.change = fmin(edge.change, threshold);
  return edge;
}

// Pixels that a probe finds wrong, by rung: an edge beside it sweeps more than one. `edges` receive what the impostor's
// texels smear, `others` what lies beyond them.
static void probe_wrong(double out[BOUND_RUNGS], ProbeEdge edges[NEIGHBOURS], const ReflectionSight *others[NEIGHBOURS],
                        const ProbeSights *sights, const CubeInfo *cube, double scale)
{
  SightErrors own = sight_errors(sights->own, cube), theirs[NEIGHBOURS];
  Vec3 direction = own.shown[BOUND_CUBE], steps[NEIGHBOURS];
  double texel_rad = cube_texel_rad(cube->size);
  memset(out, 0, BOUND_RUNGS * sizeof *out);
  memset(edges, 0, NEIGHBOURS * sizeof *edges);
  out[BOUND_ENVIRONMENT] = isfinite(sights->own->distance);
  if (!sights->beside[0] && !sights->beside[1]) return;
  for (int k = 0; k < NEIGHBOURS; k++) {
    edges[k] = probe_edge(&others[k], sights, k, scale);
    if (!edges[k].is_there) continue;
    theirs[k] = sight_errors(others[k], cube);
    steps[k] = vec3_sub(sight_errors(sights->beside[k], cube).shown[BOUND_CUBE], direction);
    edges[k].outline = theirs[k].distance < 0.8 * own.distance || own.distance < 0.8 * theirs[k].distance;
  }
  // At the reflector's rim: as much the other way.
  for (int k = 0; k < NEIGHBOURS; k++)
    if (!edges[k].is_there) steps[k] = vec3_cross(direction, steps[1 - k]);
  for (int rung = BOUND_CUBE; rung <= BOUND_IMPOSTOR; rung++) {
    double shift[NEIGHBOURS], other[NEIGHBOURS], swept = 0, smooth = 0;
    sight_shift(shift, &own, rung, steps, texel_rad);
    for (int k = 0; k < NEIGHBOURS; k++) {
      if (!edges[k].is_there) continue;
      double share = rung == BOUND_IMPOSTOR && edges[k].outline ? outline_share : 1;
      sight_shift(other, &theirs[k], rung, steps, texel_rad);
      edges[k].own_px = shift[k];
      edges[k].other_px = other[k];
      if (edges[k].weight > 0)
        swept += edges[k].weight * share * fmax(shift[k], other[k]);
      else
        smooth += edges[k].change * shift[k];
    }
    out[rung] = swept > 0 ? swept : smooth > threshold;
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

// The middle of a block's first pixel, those to the right of it and below, and the first of the next blocks.
static void sight_offsets(float out[SAMPLES][2], uint32_t block_px)
{
  float half = 0.5f / (float)block_px;
  const float offsets[SAMPLES][2] = {
      {half, half}, {3 * half, half}, {half, 3 * half}, {1 + half, half}, {half, 1 + half}};
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

static uint32_t object_met(const ReflectionSight *sight, const uint32_t *starts, uint32_t objects)
{
  return sight->met == HIT_NONE ? LIST_MET_NOTHING : object_of_triangle(starts, objects, sight->met);
}

// `cubes` and `sums`: [object_count].
static void probes_judge(BoundSums *sums, const ReflectionSights *sights, uint32_t pixels, const CubeInfo *cubes,
                         const ListBound *lists, const uint32_t *starts, uint32_t objects, uint32_t block_px, bool far,
                         double scale)
{
  for (uint32_t i = 0; i < pixels; i++) {
    const ReflectionSight *probe = &sights->sights[i], *others[NEIGHBOURS];
    if (!probe->is_reflected) continue;
    uint32_t object = object_of_triangle(starts, objects, probe->triangle);
    ProbeSights about = {.own = probe, .block_px = block_px, .far = far};
    for (uint32_t k = 0; k < 2 * NEIGHBOURS; k++) {
      const ReflectionSight *there = &sights->sights[i + (k + 1) * pixels];
      bool same = there->is_reflected && object_of_triangle(starts, objects, there->triangle) == object;
      (k < NEIGHBOURS ? about.beside : about.across)[k % NEIGHBOURS] = same ? there : NULL;
    }
    double wrong[BOUND_RUNGS];
    ProbeEdge edges[NEIGHBOURS];
    probe_wrong(wrong, edges, others, &about, &cubes[object], scale);
    for (uint32_t k = 0; k < NEIGHBOURS; k++)
      if (edges[k].is_there) edges[k].met = object_met(others[k], starts, objects);
    list_bound_wrong(wrong, lists, object, object_met(probe, starts, objects), edges, NEIGHBOURS, outline_share,
                     threshold);
    sums_add(&sums[object], wrong);
  }
}

// Of each reflector and rung what finds more wrong.
static void sums_greater(BoundSums *sums, const BoundSums *others, uint32_t objects)
{
  for (uint32_t o = 0; o < objects; o++)
    for (int rung = 0; rung < BOUND_RUNGS; rung++) {
      if (others[o].wrong[rung] <= sums[o].wrong[rung]) continue;
      sums[o].wrong[rung] = others[o].wrong[rung];
      sums[o].squares[rung] = others[o].squares[rung];
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
      if (rung >= BOUND_SNAPSHOT)
        reflector->rungs[rung].bound = list_bound_stated(rung, reflector->rungs[rung].bound, reflector->share);
      all.wrong[rung] += reflector->rungs[rung].expected * count;
      all.squares[rung] += sums[o].squares[rung];
    }
  }
  for (int rung = 0; rung < BOUND_RUNGS; rung++) {
    bound->rungs[rung] = share_of(all.wrong[rung], all.squares[rung], all.shown / count, count);
    if (rung >= BOUND_SNAPSHOT)
      bound->rungs[rung].bound = list_bound_stated(rung, bound->rungs[rung].bound, all.shown / count);
  }
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
  ListBound lists = {0};
  ReflectionSights sights = {0};
  float offsets[SAMPLES][2];
  FrameRequest request = sight_request(frame, block_px, &sights);
  ReflectionBound bound = {.reflectors = calloc(objects + 1, sizeof *bound.reflectors)};
  BoundSums *sums = calloc(objects + 1, sizeof *sums), *near = calloc(objects + 1, sizeof *near);
  CubeInfo *cubes = calloc(objects + 1, sizeof *cubes);
  uint32_t *starts = malloc((objects + 1) * sizeof *starts);
  if (!bound.reflectors || !sums || !near || !cubes || !starts) {
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
  TRY(list_bound_make(&lists, frame, cubes, log));
  probes_judge(sums, &sights, pixels, cubes, &lists, starts, objects, block_px, true, (double)scale);
  probes_judge(near, &sights, pixels, cubes, &lists, starts, objects, block_px, false, (double)scale);
  sums_greater(sums, near, objects);
  TRY(rough_bound_add(sums, frame, starts, (double)bound.probes, scale, log));
  bound_fill(&bound, sums, objects);
  *out = bound;
  bound = (ReflectionBound){0};

done:
  reflection_bound_free(&bound);
  reflection_sights_free(&sights);
  list_bound_free(&lists);
  frame_free(&probing);
  free(sums);
  free(near);
  free(cubes);
  free(starts);
  return status;
}

void reflection_bound_free(ReflectionBound *bound)
{
  free(bound->reflectors);
  *bound = (ReflectionBound){0};
}

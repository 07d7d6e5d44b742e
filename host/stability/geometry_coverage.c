#include <stdlib.h>
#include <string.h>

#include "shared/aov.h"
#include "shared/stream.h"
#include "stability/geometry_measures.h"

// A sheet that emits 1 and covers half of what is behind it: a pixel is 0.5 where it is seen once, 0 where it is
// missed, 0.75 where it is seen twice.
static Material half_sheet(void)
{
  Material material = material_plain(vec3(1, 1, 1), 0, 1);
  material.base_color[3] = 0.5f;
  material.alpha_mode = ALPHA_BLEND;
  material.unlit = true;
  material.double_sided = true;
  return material;
}

// Pixels of [low, high) x [low, high) that are not seen once.
static size_t not_once(const Shot *shot, uint32_t low, uint32_t high)
{
  size_t count = 0;
  for (uint32_t y = low; y < high; y++)
    for (uint32_t x = low; x < high; x++)
      count += !(fabs((double)shot->radiance[4 * (y * shot->width + x)] - 0.5) < 1e-3);
  return count;
}

// Share of the pixels but for `margin` at the rim that are not seen once, by raster or by rays, in either projection.
static Status coverage_measure(StabilityPoint *point, Lab *lab, const Scene *scene, uint32_t size, uint32_t margin)
{
  static const Vec3 eye = {0, 0, 4}, middle = {0, 0, 0};
  Status status = STATUS_OK;
  DeviceScene on_device = {0};
  const Camera cameras[2] = {camera_orthographic(eye, middle, 1), camera_perspective(eye, middle, 2 * atan(0.25))};
  size_t wrong = 0;
  TRY(scene_check_complete(scene, lab->log));
  TRY(device_scene_make(&on_device, lab->device, scene, NULL, lab->log));
  for (int i = 0; i < 4; i++) {
    Shot shot = {0};
    RenderSettings settings = lab_settings(size, size);
    settings.primary = i & 1 ? PRIMARY_RASTER : PRIMARY_RAYS;
    TRY(lab_render(&shot, lab, &on_device, &cameras[i / 2], &settings));
    size_t missed = not_once(&shot, margin, size - margin);
    float *right = malloc(shot_pixels(&shot) * sizeof *right), *seen = malloc(shot_pixels(&shot) * sizeof *seen);
    for (size_t k = 0; k < shot_pixels(&shot) && right && seen; k++) right[k] = 0.5f, seen[k] = shot.radiance[4 * k];
    if (right && seen && (i == 0 || missed > 0)) status = lab_keep(lab, seen, right, size, size, 1);
    free(right);
    free(seen);
    shot_free(&shot);
    if (status) goto done;
    wrong += missed;
  }
  point->measured = (double)wrong / (4.0 * (size - 2 * margin) * (size - 2 * margin));

done:
  device_scene_free(&on_device);
  return status;
}

// Upright strips over the whole view, every second one as thin as the aspect says, their edges through the middles of
// pixels where there is room; a triangle without area beside each.
Status measure_slivers(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  uint32_t size = lab->quick ? 64 : 256;
  double pixel = 2.0 / size, thin = 2 / point->value;
  const Vec3 normals[3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  Scene scene = scene_empty();
  int sheet = scene_add_material(&scene, half_sheet());
  double left = -1.2;
  for (int i = 0; left < 1.2; i++) {
    double right = i % 2 ? left + thin : -1 + (floor((left + 1) / pixel) + 5.5) * pixel;
    if ((float)right <= (float)left) right = left;
    const Vec3 below = {left, -1, 0}, above = {left, 1, 0}, far_below = {right, -1, 0}, far_above = {right, 1, 0};
    scene_add_triangle(&scene, sheet, (const Vec3[3]){below, far_below, far_above}, normals);
    scene_add_triangle(&scene, sheet, (const Vec3[3]){below, far_above, above}, normals);
    scene_add_triangle(&scene, sheet, (const Vec3[3]){far_below, far_above, far_below}, normals);
    left = right;
  }
  Status status = coverage_measure(point, lab, &scene, size, 2);
  scene_free(&scene);
  return status;
}

// Triangles about the middle of a pixel, to points about the rim: the sweep is how many.
Status measure_fan(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  uint32_t size = lab->quick ? 64 : 256, count = (uint32_t)point->value;
  const Vec3 normals[3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}, apex = {1.0 / size, 1.0 / size, 0};
  Scene scene = scene_empty();
  int sheet = scene_add_material(&scene, half_sheet());
  for (uint32_t i = 0; i < count; i++) {
    Vec3 rim[2];
    for (uint32_t k = 0; k < 2; k++) {
      double angle = 2 * M_PI * ((i + k) % count) / count;
      rim[k] = vec3_add(apex, vec3(2 * cos(angle), 2 * sin(angle), 0));
    }
    scene_add_triangle(&scene, sheet, (const Vec3[3]){apex, rim[0], rim[1]}, normals);
  }
  // A fan of three reaches to half its radius.
  Status status = coverage_measure(point, lab, &scene, size, size / 6);
  scene_free(&scene);
  return status;
}

// A quad about a middle: its sides, and where that is.
typedef struct Sheet {
  Vec3 u, v, middle;
} Sheet;

// In a plane through the origin tilted by `degrees`, turned within it, and `lift` before it.
static Sheet sheet_tilted(double degrees, double turn, double lift)
{
  double tilt = degrees * M_PI / 180;
  Vec3 along = vec3(cos(tilt), 0, sin(tilt)), across = vec3(0, 1, 0);
  return (Sheet){vec3_scale(vec3_add(vec3_scale(along, cos(turn)), vec3_scale(across, sin(turn))), 2),
                 vec3_scale(vec3_sub(vec3_scale(across, cos(turn)), vec3_scale(along, sin(turn))), 2),
                 vec3_scale(vec3_cross(along, across), lift)};
}

// Is a point, of the plane or near it, within the sheet and not at its rim?
static bool sheet_covers(const Sheet *sheet, Vec3 point)
{
  Vec3 from_middle = vec3_sub(point, sheet->middle);
  return fabs(vec3_dot(from_middle, sheet->u)) < 0.48 * vec3_dot(sheet->u, sheet->u) &&
         fabs(vec3_dot(from_middle, sheet->v)) < 0.48 * vec3_dot(sheet->v, sheet->v);
}

// Counts, where both sheets are, which is seen, and where raster and rays disagree.
typedef struct Winners {
  size_t of_first, of_second, disagree;
} Winners;

static Status winners_count(Winners *out, Lab *lab, const DeviceScene *scene, const Sheet sheets[2], uint32_t frame)
{
  Status status = STATUS_OK;
  Shot by_rays = {0}, by_raster = {0};
  uint32_t size = lab->quick ? 64 : 192;
  Vec3 eye = vec3(0.031 * frame - 0.1, 0.017 * frame, 3 + 0.013 * frame);
  Camera camera = camera_perspective(eye, vec3(0, 0, 0), 0.3);
  RenderSettings settings = lab_settings(size, size);
  TRY(lab_render(&by_rays, lab, scene, &camera, &settings));
  settings.primary = PRIMARY_RASTER;
  TRY(lab_render(&by_raster, lab, scene, &camera, &settings));
  TRY(lab_keep(lab, by_raster.radiance, by_rays.radiance, size, size, 4));
  for (size_t i = 0; i < shot_pixels(&by_rays); i++) {
    Vec3 at = shot_vector(&by_rays, i, AOV_POSITION);
    if (!sheet_covers(&sheets[0], at) || !sheet_covers(&sheets[1], at)) continue;
    out->of_first += by_rays.ids[i] == 0;
    out->of_second += by_rays.ids[i] == 1;
    out->disagree += by_rays.ids[i] != by_raster.ids[i];
  }

done:
  shot_free(&by_rays);
  shot_free(&by_raster);
  return status;
}

// Share of where both are that does not see the one that most of it sees, as a camera passes, or where raster and rays
// disagree.
static Status coplanar_measure(StabilityPoint *point, Lab *lab, const Sheet sheets[2])
{
  Status status = STATUS_OK;
  DeviceScene on_device = {0};
  Winners winners = {0};
  Scene scene = scene_empty();
  const int colors[2] = {scene_add_material(&scene, material_glowing(vec3(0.8, 0.8, 0.8))),
                         scene_add_material(&scene, material_glowing(vec3(0.1, 0.1, 0.1)))};
  for (int i = 0; i < 2; i++) {
    Vec3 half = vec3_scale(vec3_add(sheets[i].u, sheets[i].v), 0.5);
    scene_add_quad(&scene, colors[i], vec3_sub(sheets[i].middle, half), sheets[i].u, sheets[i].v);
  }
  TRY(scene_check_complete(&scene, lab->log));
  TRY(device_scene_make(&on_device, lab->device, &scene, NULL, lab->log));
  for (uint32_t frame = 0; frame < (lab->quick ? 3 : 12); frame++)
    TRY(winners_count(&winners, lab, &on_device, sheets, frame));
  size_t flips = winners.of_first < winners.of_second ? winners.of_first : winners.of_second;
  double all = (double)(winners.of_first + winners.of_second);
  point->measured = all > 0 ? (double)(flips + winners.disagree) / all : NAN;

done:
  device_scene_free(&on_device);
  scene_free(&scene);
  return status;
}

// The same quad twice; the sweep is the tilt of its plane in degrees.
Status measure_coplanar_twins(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  const Sheet sheets[2] = {sheet_tilted(point->value, 0.3, 0), sheet_tilted(point->value, 0.3, 0)};
  return coplanar_measure(point, lab, sheets);
}

// Two quads turned against each other in planes a little apart; the sweep is how far, in metres.
Status measure_coplanar(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const double reach_m = 5, roundings = 64 * 0x1p-24;  // lib/triangle.cl
  const Sheet sheets[2] = {sheet_tilted(20, 0.3, 0), sheet_tilted(20, 0.8, point->value)};
  Status status = coplanar_measure(point, lab, sheets);
  // Nearer than the triangle test's rounding either is seen: the one that fewer pixels see is seen by half at most.
  if (point->value < reach_m * roundings) point->warned = 0.5;
  return status;
}

// Source: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", 2014 (SplitMix64).
static double random_share(uint64_t *state)
{
  uint64_t z = *state += 0x9e3779b97f4a7c15ull;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ z >> 27) * 0x94d049bb133111ebull;
  return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

enum { RAYS_PER_LAUNCH = 1 << 16 };

// Rays from within a closed mesh at its vertices and edges, those at edges at any point, near an end too.
static void edge_rays_make(float *fields, const Primitive *mesh, uint64_t *random)
{
  for (uint32_t i = 0; i < RAYS_PER_LAUNCH; i++) {
    const uint32_t *corners = mesh->triangles[(uint32_t)(random_share(random) * mesh->triangle_count)];
    uint32_t corner = (uint32_t)(random_share(random) * 3), kind = (uint32_t)(random_share(random) * 3);
    const float *from = mesh->positions[corners[corner]], *to = mesh->positions[corners[(corner + 1) % 3]];
    double along = kind == 0 ? 0 : kind == 1 ? random_share(random) : pow(10, -8 * random_share(random));
    for (int axis = 0; axis < 3; axis++) {
      float origin = (float)(0.4 * random_share(random) - 0.2);
      double target = from[axis] + along * ((double)to[axis] - (double)from[axis]);
      fields[(RAY_ORIGIN_X + axis) * RAYS_PER_LAUNCH + i] = origin;
      fields[(RAY_DIRECTION_X + axis) * RAYS_PER_LAUNCH + i] = (float)(target - (double)origin);
    }
    fields[RAY_T_MAX * RAYS_PER_LAUNCH + i] = INFINITY;
  }
}

// Misses of as many rays as it takes, by both ways of walking the tree in turns.
static Status edge_rays_trace(double *misses, Lab *lab, const DeviceScene *scene, const Primitive *mesh,
                              uint32_t launches)
{
  Status status = STATUS_OK;
  Tracer tracer = {0};
  RayStream rays = {0};
  HitStream hits = {0};
  uint64_t random = mesh->triangle_count;
  size_t bytes = (size_t)RAY_FIELD_COUNT * RAYS_PER_LAUNCH * sizeof(float);
  float *fields = calloc(1, bytes);
  uint32_t *ids = calloc(RAYS_PER_LAUNCH, sizeof *ids);
  *misses = 0;
  if (!fields || !ids) {
    status = log_no_memory(lab->log, "rays");
    goto done;
  }
  TRY(tracer_make(&tracer, lab->device, scene, lab->log));
  TRY(ray_stream_make(&rays, lab->device, RAYS_PER_LAUNCH, 1, "rays", lab->log));
  TRY(hit_stream_make(&hits, lab->device, RAYS_PER_LAUNCH, lab->log));
  for (uint32_t launch = 0; launch < launches; launch++) {
    edge_rays_make(fields, mesh, &random);
    TRY(buffer_write(lab->device, &rays.rays, fields, bytes, lab->log));
    TRY(trace_closest(&tracer, lab->device, scene, &rays, RAYS_PER_LAUNCH, 0, &hits,
                      launch % 2 ? RAYS_INCOHERENT : RAYS_COHERENT, "trace rays at edges", lab->log));
    TRY(buffer_read(lab->device, &hits.ids, ids, RAYS_PER_LAUNCH * sizeof *ids, lab->log));
    for (uint32_t i = 0; i < RAYS_PER_LAUNCH; i++) *misses += ids[i] == HIT_NONE;
  }

done:
  tracer_free(&tracer);
  ray_stream_free(&rays);
  hit_stream_free(&hits);
  free(fields);
  free(ids);
  return status;
}

// A closed sphere seen from inside; the sweep is its rings. 10^7 rays over the whole sweep.
Status measure_shared_edges(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  DeviceScene on_device = {0};
  Scene scene = scene_empty();
  Material material = material_plain(vec3(1, 1, 1), 0, 1);
  material.double_sided = true;
  scene_add_sphere(&scene, scene_add_material(&scene, material), vec3(0.01, -0.02, 0.03), 1, (int)point->value);
  TRY(scene_check_complete(&scene, lab->log));
  TRY(device_scene_make(&on_device, lab->device, &scene, NULL, lab->log));
  TRY(edge_rays_trace(&point->measured, lab, &on_device, scene.meshes[0].primitives, lab->quick ? 2 : 39));

done:
  device_scene_free(&on_device);
  scene_free(&scene);
  return status;
}

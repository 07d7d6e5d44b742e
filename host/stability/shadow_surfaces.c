#include <stdlib.h>

#include "shared/aov.h"
#include "stability/lit_view.h"
#include "stability/shadow_measures.h"

double shadow_reach_texels(ShadowMethod method, uint32_t kernel_px)
{
  const double half_diagonal = 0.75;
  if (method == SHADOWS_MAP) return half_diagonal;
  if (method == SHADOWS_PCF) return half_diagonal + 0.5 * kernel_px;
  return method == SHADOWS_PCSS ? half_diagonal + 0.5 : 0;
}

static Vec3 turned(const double rotation[4], Vec3 v)
{
  Mat4 m = mat4_from_trs(vec3(0, 0, 0), rotation, vec3(1, 1, 1));
  return mat4_direction(&m, v);
}

// Degrees between a normal and the way to a light.
static double light_angle(const Light *light, Vec3 point, Vec3 normal)
{
  Vec3 to_light =
      light->kind == LIGHT_DIRECTIONAL ? vec3_neg(light->direction_world) : vec3_sub(light->position_world, point);
  return acos(vec3_dot(vec3_unit_or(to_light, normal), normal)) * 180 / M_PI;
}

// Share of the pixels, of those whose light comes from no farther off the normal than `degrees`, that are darkened.
static double dark_share(const LitView *view, const Light *light, double degrees)
{
  size_t dark = 0, all = 0;
  for (size_t i = 0; i < shot_pixels(&view->truth); i++) {
    Vec3 at = shot_vector(&view->truth, i, AOV_POSITION), normal = shot_vector(&view->truth, i, AOV_NORMAL);
    if (!view->seen[i] || light_angle(light, at, normal) > degrees + 1e-3) continue;
    all++;
    dark += lab_differ((double)view->lit[i], 1);
  }
  return all ? (double)dark / (double)all : 0;
}

// A plane of 12 x 12 quads, turned so that no axis and no texel lies along it, alone in the light.
Status measure_acne(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  enum { CELLS = 12 };
  static const double rotation[4] = {0.35, 0.2, 0.45, 0.8}, most_degrees = 85;
  Status status = STATUS_OK;
  uint32_t size = lab->quick ? 64 : 192;
  double slant = point->value * M_PI / 180;
  Vec3 u = turned(rotation, vec3(1, 0, 0)), v = turned(rotation, vec3(0, 1, 0)),
       normal = turned(rotation, vec3(0, 0, 1));
  Vec3 side = vec3_add(vec3_scale(u, cos(0.3)), vec3_scale(v, sin(0.3)));
  Vec3 to_light = vec3_add(vec3_scale(normal, cos(slant)), vec3_scale(side, sin(slant)));
  const Light lights[3] = {light_directional(vec3_neg(to_light), M_PI), light_point(vec3_scale(to_light, 4), 16 * M_PI),
                           light_spot(vec3_scale(to_light, 4), vec3(0, 0, 0), 16 * M_PI, 0.5, 0.6)};
  Camera camera = camera_orthographic(vec3_scale(normal, 3), vec3(0, 0, 0), 0.9);
  point->bound = point->warned = point->value <= most_degrees ? 0 : INFINITY;
  double worst = -1;
  for (int kind = 0; kind < 3; kind++) {
    LitView view = {0};
    Scene scene = scene_empty();
    int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
    for (int i = 0; i < CELLS * CELLS; i++) {
      double x = (i % CELLS) * 2.0 / CELLS - 1, y = (double)(i / CELLS) * 2 / CELLS - 1;
      scene_add_quad(&scene, white, vec3_add(vec3_scale(u, x), vec3_scale(v, y)), vec3_scale(u, 2.0 / CELLS),
                     vec3_scale(v, 2.0 / CELLS));
    }
    scene_add_light(&scene, lights[kind]);
    status = lit_view_make(&view, lab, &scene, &camera, size, size, method, NULL);
    double share = status ? 0 : dark_share(&view, &lights[kind], point->value);
    if (!status && share > worst) {
      worst = share;
      status = lit_view_keep(&view, lab);
    }
    lit_view_free(&view);
    scene_free(&scene);
    if (status) break;
  }
  point->measured = worst;
  return status;
}

// A wall that stands on a floor, the sun over it; how far from its foot the shadow begins.
Status measure_peter_panning(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const double azimuth = 0.35, height = 1;
  Status status = STATUS_OK;
  LitView view = {0};
  ShadowOptions options = {.kernel_px = 3, .map_size_px = 512};
  uint32_t size = lab->quick ? 96 : 256;
  double elevation = point->value * M_PI / 180;
  Vec3 up = vec3(0, 1, 0);
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  scene_add_quad(&scene, white, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8));
  scene_add_box(&scene, white, vec3(-0.1, 0, -2), vec3(0, height, 2));
  scene_add_light(
      &scene,
      light_directional(vec3(cos(elevation) * cos(azimuth), -sin(elevation), cos(elevation) * sin(azimuth)), M_PI));
  Camera camera = camera_orthographic(vec3(3, 4, 0), vec3(0.12, 0, 0), 0.12);
  TRY(lit_view_make(&view, lab, &scene, &camera, size, size, method, &options));
  TRY(lit_view_keep(&view, lab));
  double texel_m = lit_view_texel_m(&view, vec3(0, 0, 0)), bias_m = lit_view_bias_m(&view, vec3(0, 0, 0), up);
  double texels = method == SHADOWS_PCF ? 1 + 0.5 * options.kernel_px : method == SHADOWS_PCSS ? 1.5 : 1;
  for (size_t i = 0; i < shot_pixels(&view.truth); i++) {
    Vec3 at = shot_vector(&view.truth, i, AOV_POSITION);
    bool on_floor = view.seen[i] && fabs(at.y) < 1e-4 && at.x > 0 && at.x < 0.5 * height / tan(elevation);
    if (on_floor && view.rays[i] < 0.5f && lab_differ((double)view.lit[i], 0))
      point->measured = fmax(point->measured, at.x);
  }
  point->bound = (bias_m * cos(elevation) + texels * texel_m / sin(elevation)) * cos(azimuth);
  point->warned = point->bound;

done:
  lit_view_free(&view);
  scene_free(&scene);
  return status;
}

// Two planes that meet in a fold, both in the sun; the sweep is the angle between them. A kernel on one of them, or the
// middle of a texel, reaches over the fold, where the other stands before the first one's plane.
Status measure_fold(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  LitView view = {0};
  const ShadowOptions options = {.kernel_px = 3, .map_size_px = 256};
  uint32_t size = lab->quick ? 64 : 192;
  double half = point->value / 2 * M_PI / 180;
  Vec3 along = vec3(4, 0, 0), right = vec3(0, 2 * cos(half), 2 * sin(half)), left = vec3(0, right.y, -right.z);
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  scene_add_quad(&scene, white, vec3(-2, 0, 0), right, along);
  scene_add_quad(&scene, white, vec3(-2, 0, 0), along, left);
  scene_add_light(&scene, light_directional(vec3(0.13, -1, 0.07), M_PI));
  Camera camera = camera_orthographic(vec3(0, 3, 0), vec3(0.02, 0, 0.01), 0.5);
  TRY(lit_view_make(&view, lab, &scene, &camera, size, size, method, &options));
  TRY(lit_view_keep(&view, lab));
  double seen = (double)lit_view_seen(&view);
  point->measured = (double)lit_view_wrong(&view) / seen;
  // On either side; a band holds as many pixels as it is wide, and one.
  double reach = shadow_reach_texels(method, options.kernel_px);
  point->bound = reach > 0 ? (2 * lit_view_end_pixels(&view, reach) + size) / seen : 0;
  point->warned = point->bound;

done:
  lit_view_free(&view);
  scene_free(&scene);
  return status;
}

// Two rooms under one roof with a sheet between them, a lamp in one; floor of the other, beyond the kernel.
Status measure_bleeding(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const Vec3 lamp = {-1, 1, 0.1};
  Status status = STATUS_OK;
  LitView view = {0};
  ShadowOptions options = {.kernel_px = (uint32_t)point->value, .map_size_px = 256};
  uint32_t size = lab->quick ? 64 : 192;
  size_t lit = 0;
  Scene scene = scene_empty();
  Material material = material_plain(vec3(1, 1, 1), 0, 1);
  material.double_sided = true;
  int white = scene_add_material(&scene, material);
  scene_add_box(&scene, white, vec3(-2, 0, -2), vec3(2, 2, 2));
  scene_add_quad(&scene, white, vec3(0, 0, -2), vec3(0, 2, 0), vec3(0, 0, 4));
  scene_add_light(&scene, light_point(lamp, 4 * M_PI));
  Camera camera = camera_orthographic(vec3(1, 1.9, 0), vec3(1, 0, 0), 1);
  TRY(lit_view_make(&view, lab, &scene, &camera, size, size, method, &options));
  TRY(lit_view_keep(&view, lab));
  size_t seen = 0;
  for (size_t i = 0; i < shot_pixels(&view.truth); i++) {
    // Kernel, texel, and what must stand before the receiver, in texels along x on the floor.
    Footprint texel;
    if (!view.seen[i] || !lit_view_footprint(&texel, &view, i)) continue;
    double across_m = (fabs(texel.x[0]) + fabs(texel.y[0])) * (double)view.truth.camera.scale;
    double reach_m = (0.5 * options.kernel_px + 1 + (double)view.fit.info.slope_px) * across_m;
    if (shot_vector(&view.truth, i, AOV_POSITION).x < reach_m) continue;
    seen++;
    lit += lab_differ((double)view.lit[i], 0);
  }
  point->measured = seen ? (double)lit / (double)seen : NAN;

done:
  lit_view_free(&view);
  scene_free(&scene);
  return status;
}

// A plate over a floor under a spot light: the soft rung less the hard one as the light's radius goes to nothing.
Status measure_zero_size(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const double lamp_m = 2, plate_m = 1.05;
  Status status = STATUS_OK;
  LitView soft = {0}, hard = {0};
  ShadowOptions options = {.kernel_px = 1, .map_size_px = 256, .light_radius_m = (float)point->value};
  const ShadowOptions point_options = {.kernel_px = 1, .map_size_px = 256};
  ShadowMethod reference = method == SHADOWS_AREA ? SHADOWS_RAYS : method;
  uint32_t size = lab->quick ? 64 : 192;
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  scene_add_quad(&scene, white, vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4));
  scene_add_box(&scene, white, vec3(-0.4, plate_m - 0.05, -0.3), vec3(0.3, plate_m, 0.35));
  scene_add_light(&scene, light_spot(vec3(0.1, lamp_m, 0.05), vec3(0, 0, 0), 4 * M_PI, 0.7, 0.8));
  Camera camera = camera_orthographic(vec3(0, 0.9, 0), vec3(0, 0, 0), 1.2);
  TRY(lit_view_make(&soft, lab, &scene, &camera, size, size, method, &options));
  TRY(lit_view_make(&hard, lab, &scene, &camera, size, size, reference, &point_options));
  TRY(lab_keep(lab, soft.lit, hard.lit, size, size, 1));
  size_t different = 0;
  for (size_t i = 0; i < shot_pixels(&soft.truth); i++)
    different += soft.seen[i] && lab_differ((double)soft.lit[i], (double)hard.lit[i]);
  // Share of the pixels in the half-shadow of the plate's top; PCSS adds a texel on either side, and is hard where its
  // disc is no wider than one.
  double texel_m = lit_view_texel_m(&soft, vec3(0, 0, 0)), edges = (double)lit_view_edges(&hard);
  double half_shadow_m = 2 * point->value * plate_m / (lamp_m - plate_m);
  if (method == SHADOWS_PCSS) half_shadow_m = half_shadow_m > 0.9 * texel_m ? half_shadow_m + 2 * texel_m : 0;
  double share = edges * half_shadow_m / (double)soft.truth.camera.scale / (double)lit_view_seen(&soft);
  point->measured = (double)different / (double)lit_view_seen(&soft);
  point->bound = point->warned = share;

done:
  lit_view_free(&soft);
  lit_view_free(&hard);
  scene_free(&scene);
  return status;
}

#include "stability/reflection_measures.h"

#include <math.h>
#include <stdlib.h>

#include "plan/cube_error.h"
#include "stability/mirror_view.h"

static Vec3 wide(Float3 v) { return vec3(v.x, v.y, v.z); }

// Direction of the view at a point of the picture, in pixels.
static Vec3 sight_at(const Shot *shot, double x, double y)
{
  const CameraInfo *camera = &shot->camera;
  double scale = (double)camera->scale;
  Vec3 across = vec3_scale(wide(camera->right), x * scale - (double)camera->center_x);
  Vec3 down = vec3_scale(wide(camera->down), y * scale - (double)camera->center_y);
  return vec3_add(wide(camera->forward), vec3_add(across, down));
}

static double angle_between(Vec3 a, Vec3 b) { return atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b)); }

// ---- parallax -------------------------------------------------------------------------------------------------------

// The middle of all that glows, by its radiance; not finite where nothing does.
static Vec3 glow_sight(const Shot *shot)
{
  double sum = 0, x = 0, y = 0;
  for (size_t i = 0; i < shot_pixels(shot); i++) {
    double weight = (double)shot->radiance[4 * i];
    sum += weight;
    x += weight * ((double)(i % shot->width) + 0.5);
    y += weight * ((double)(i / shot->width) + 0.5);
  }
  return sight_at(shot, x / sum, y / sum);
}

static Status parallax_measure(StabilityPoint *point, Lab *lab, ReflectionMethod method)
{
  enum { SIDE = 160, CUBE_PX = 256 };
  static const double view_rad = 0.9;
  Status status = STATUS_OK;
  Shot by_method = {0}, by_rays = {0};
  double distance = point->value;
  Vec3 target = vec3_scale(vec3_unit_or(vec3(0.3, 0.2, 1), vec3(0, 0, 1)), distance);
  Vec3 eye = vec3(-1.2, -0.8, 1.2);
  Scene scene = scene_empty();
  scene_add_quad(&scene, mirror_view_material(&scene, 0.9), vec3(-3, -3, 0), vec3(6, 0, 0), vec3(0, 6, 0));
  scene_add_sphere(&scene, scene_add_material(&scene, material_glowing(vec3(1, 1, 1))), target, 0.08 * distance, 16);
  Camera camera = camera_perspective(eye, vec3(-0.6, -0.4, 0), view_rad);
  TRY(mirror_view_render(&by_method, &by_rays, lab, &scene, &camera, &(MirrorView){method, SIDE, CUBE_PX, 0}));
  Vec3 sight = glow_sight(&by_rays), at = vec3_sub(eye, vec3_scale(sight, eye.z / sight.z));
  CubeSight ray = {vec3_length(at), distance, angle_between(at, vec3(sight.x, sight.y, -sight.z))};
  point->measured = angle_between(glow_sight(&by_method), sight);
  point->bound = 0.5 * cube_texel_rad(CUBE_PX) + 0.1 * view_rad / SIDE;
  if (method == REFLECTIONS_CUBE) point->bound += cube_parallax_rad(&ray);
  point->warned = point->bound;

done:
  shot_free(&by_method);
  shot_free(&by_rays);
  scene_free(&scene);
  return status;
}

Status measure_cube_parallax(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  return parallax_measure(point, lab, REFLECTIONS_CUBE);
}

Status measure_impostor_parallax(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  return parallax_measure(point, lab, REFLECTIONS_IMPOSTOR);
}

// ---- seams ----------------------------------------------------------------------------------------------------------

static int face_of(Vec3 d)
{
  double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
  if (x >= y && x >= z) return d.x < 0;
  return y >= z ? 2 + (d.y < 0) : 4 + (d.z < 0);
}

// As smooth as a cosine.
static void sky_paint(Scene *scene)
{
  enum { WIDTH = 512, HEIGHT = 256 };
  float(*colors)[3] = calloc((size_t)WIDTH * HEIGHT, sizeof *colors);
  for (int i = 0; i < WIDTH * HEIGHT && colors; i++) {
    double p = 2 * M_PI * ((i % WIDTH + 0.5) / WIDTH - 0.5), t = M_PI * (i / WIDTH + 0.5) / HEIGHT;
    colors[i][0] = (float)(2 + cos(p) * sin(t));
    colors[i][1] = (float)(2 + cos(t));
    colors[i][2] = (float)(2 + sin(p) * sin(t));
  }
  if (colors)
    scene_set_image(scene, WIDTH, HEIGHT, (const float(*)[3])colors);
  else
    scene->incomplete = true;
  free(colors);
}

static Status seam_measure(double *across, double *within, Lab *lab, double turned_rad)
{
  enum { SIDE = 96, CUBE_PX = 16 };
  Status status = STATUS_OK;
  Shot by_method = {0}, by_rays = {0};
  const double c = cos(turned_rad), s = sin(turned_rad);
  const Vec3 u = {c, 0, -s}, v = {0, 1, 0}, n = {s, 0, c};
  Scene scene = scene_empty();
  sky_paint(&scene);
  Vec3 corner = vec3_scale(vec3_add(u, v), -30);
  scene_add_quad(&scene, mirror_view_material(&scene, 0.9), corner, vec3_scale(u, 60), vec3_scale(v, 60));
  Camera camera = camera_perspective(vec3_scale(n, 2), vec3(0, 0, 0), 1.9);
  const MirrorView view = {REFLECTIONS_CUBE, SIDE, CUBE_PX, 0};
  TRY(mirror_view_render(&by_method, &by_rays, lab, &scene, &camera, &view));
  for (size_t i = 0; i + 1 < SIDE * SIDE; i++) {
    if (i % SIDE + 1 == SIDE) continue;
    int faces[2];
    double errors[2], jump = 0;
    for (size_t k = 0; k < 2; k++) {
      Vec3 d = sight_at(&by_rays, (double)((i + k) % SIDE) + 0.5, (double)(i / SIDE) + 0.5);
      faces[k] = face_of(vec3_sub(d, vec3_scale(n, 2 * vec3_dot(d, n))));
    }
    for (size_t channel = 0; channel < 3; channel++) {
      for (size_t k = 0; k < 2; k++)
        errors[k] = (double)by_method.radiance[4 * (i + k) + channel] - (double)by_rays.radiance[4 * (i + k) + channel];
      jump = fmax(jump, fabs(errors[1] - errors[0]));
    }
    double *most = faces[0] == faces[1] ? within : across;
    *most = fmax(*most, jump);
  }

done:
  shot_free(&by_method);
  shot_free(&by_rays);
  scene_free(&scene);
  return status;
}

Status measure_cube_seam(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  double across = 0, within = 0;
  Status status = seam_measure(&across, &within, lab, point->value * M_PI / 180);
  point->measured = across;
  point->bound = point->warned = within;
  return status;
}

// ---- what is near ---------------------------------------------------------------------------------------------------

Status measure_self_reflection(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  double apart = 0.4 + point->value / 2;
  Scene scene = scene_empty();
  int mirror = mirror_view_material(&scene, 0.9);
  scene_add_sphere(&scene, mirror, vec3(-apart, 0, 0), 0.4, 32);
  scene_add_sphere(&scene, mirror, vec3(apart, 0, 0), 0.4, 32);
  scene_join_last(&scene);
  mirror_view_walls(&scene);
  Camera camera = camera_perspective(vec3(0.3, 0.8, 3), vec3(0, 0, 0), 0.9);
  Status status = mirror_view_wrong(&point->measured, lab, &scene, &camera, REFLECTIONS_IMPOSTOR, 0);
  point->bound = point->warned = 0;
  scene_free(&scene);
  return status;
}

Status measure_bounds_crossing(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const double radius = 0.6;
  double from = radius + point->value;
  Scene scene = scene_empty();
  scene_add_sphere(&scene, mirror_view_material(&scene, 0.9), vec3(0, 0, 0), radius, 32);
  mirror_view_walls(&scene);
  int glow = scene_add_material(&scene, material_glowing(vec3(0.9, 0.9, 0.9)));
  scene_add_box(&scene, glow, vec3(from, from, from), vec3(from + 0.5, from + 0.5, from + 0.5));
  Camera camera = camera_perspective(vec3(1, 0.5, 3.2), vec3(0, 0, 0), 0.5);
  Status status = mirror_view_wrong(&point->measured, lab, &scene, &camera, REFLECTIONS_IMPOSTOR, 0);
  point->bound = point->warned = 0;
  scene_free(&scene);
  return status;
}

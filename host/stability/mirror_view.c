#include "stability/mirror_view.h"

#include <math.h>

#include "shared/aov.h"

int mirror_view_material(Scene *scene, double reflectance)
{
  return scene_add_material(scene, material_plain(vec3(reflectance, reflectance, reflectance), 1, 0));
}

Status mirror_view_render(Shot *by_method, Shot *by_rays, Lab *lab, const Scene *scene, const Camera *camera,
                          const MirrorView *view)
{
  enum { COMPLEX_FROM = 100 };
  Status status = STATUS_OK;
  const uint32_t side = view->side_px;
  RenderSettings settings = lab_settings(side, side);
  settings.reflections = view->method;
  settings.cubes.size_px = view->cube_px;
  settings.cubes.near_radius_m = view->near_radius_m;
  settings.cubes.complex_from = COMPLEX_FROM;
  TRY(lab_render_scene(by_method, lab, scene, camera, &settings));
  settings.reflections = REFLECTIONS_RAYS;
  TRY(lab_render_scene(by_rays, lab, scene, camera, &settings));
  TRY(lab_keep(lab, by_method->radiance, by_rays->radiance, side, side, 4));

done:
  return status;
}

// Does a pixel of the first object show one thing, as rays have it, in itself and its neighbours, two either way? These
// are farther apart than a texel of the maps in use.
static bool is_even(const Shot *shot, size_t i)
{
  enum { REACH = 2, ACROSS = 2 * REACH + 1 };
  size_t width = shot->width, x = i % width, y = i / width;
  if (x < REACH || x + REACH >= width || y < REACH || y + REACH >= shot->height) return false;
  for (size_t k = 0; k < ACROSS * ACROSS; k++) {
    size_t there = i + (k / ACROSS) * width + k % ACROSS - REACH * (width + 1);
    if (shot->ids[AOV_OBJECT * shot_pixels(shot) + there] != 0) return false;
    for (size_t c = 0; c < 3; c++)
      if (lab_differ((double)shot->radiance[4 * there + c], (double)shot->radiance[4 * i + c])) return false;
  }
  return true;
}

Status mirror_view_wrong(double *share, Lab *lab, const Scene *scene, const Camera *camera, ReflectionMethod method,
                         float near_radius_m)
{
  Status status = STATUS_OK;
  const MirrorView view = {method, lab->quick ? 96 : 192, lab->quick ? 256 : 512, near_radius_m};
  Shot by_method = {0}, by_rays = {0};
  size_t even = 0, wrong = 0;
  TRY(mirror_view_render(&by_method, &by_rays, lab, scene, camera, &view));
  for (size_t i = 0; i < shot_pixels(&by_rays); i++) {
    bool differs = false;
    if (!is_even(&by_rays, i)) continue;
    for (size_t c = 0; c < 3; c++)
      differs |= lab_differ((double)by_method.radiance[4 * i + c], (double)by_rays.radiance[4 * i + c]);
    even++;
    wrong += differs;
  }
  *share = even ? (double)wrong / (double)even : NAN;

done:
  shot_free(&by_method);
  shot_free(&by_rays);
  return status;
}

void mirror_view_walls(Scene *scene)
{
  static const double colors[6][3] = {{0.8, 0.2, 0.2}, {0.2, 0.8, 0.2}, {0.2, 0.2, 0.8},
                                      {0.8, 0.8, 0.2}, {0.2, 0.8, 0.8}, {0.8, 0.2, 0.8}};
  const Vec3 low = {-3, -2.5, -3.5}, x = {6.5, 0, 0}, y = {0, 5.5, 0}, z = {0, 0, 7};
  const Vec3 walls[6][3] = {{low, y, z}, {vec3_add(low, x), z, y}, {low, z, x}, {vec3_add(low, y), x, z},
                            {low, x, y}, {vec3_add(low, z), y, x}};
  for (int i = 0; i < 6; i++)
    scene_add_quad(scene, scene_add_material(scene, material_glowing(vec3(colors[i][0], colors[i][1], colors[i][2]))),
                   walls[i][0], walls[i][1], walls[i][2]);
}

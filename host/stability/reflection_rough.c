#include "stability/mirror_view.h"
#include "stability/reflection_measures.h"

// A varnished ball that fills the picture, among walls that glow as it does.
Status measure_roughness(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  enum { SIDE = 32, REFERENCE_SAMPLES = 16384 };
  Status status = STATUS_OK;
  Shot by_cube = {0}, by_rays = {0};
  DeviceScene on_device = {0};
  Scene scene = scene_empty();
  Material varnish = material_plain(vec3(0, 0, 0), 0, point->value);
  varnish.emission[0] = varnish.emission[1] = varnish.emission[2] = 0.4f;
  mirror_view_walls(&scene);
  scene_add_sphere(&scene, scene_add_material(&scene, varnish), vec3(0, 0, 0), 0.5, 64);
  const Camera camera = camera_perspective(vec3(0.6, 0.7, 2), vec3(0, 0, 0), 0.44);
  RenderSettings settings = lab_settings(SIDE, SIDE);
  settings.lighting = LIGHTING_PBR;
  settings.max_roughness = 1;
  settings.reflections = REFLECTIONS_CUBE;
  TRY(scene_check_complete(&scene, lab->log));
  TRY(device_scene_make(&on_device, lab->device, &scene, NULL, lab->log));
  TRY(lab_render(&by_cube, lab, &on_device, &camera, &settings));
  TRY(lab_reflection_bound(&point->bound, lab, &on_device, &camera, &settings));
  settings.reflections = REFLECTIONS_RAYS;
  settings.samples = REFERENCE_SAMPLES;
  TRY(lab_render(&by_rays, lab, &on_device, &camera, &settings));
  TRY(lab_keep(lab, by_cube.radiance, by_rays.radiance, SIDE, SIDE, 4));
  point->measured = (double)lab_count_different(&by_cube, &by_rays) / (SIDE * SIDE);
  point->warned = point->bound;

done:
  shot_free(&by_cube);
  shot_free(&by_rays);
  device_scene_free(&on_device);
  scene_free(&scene);
  return status;
}

#include <stdlib.h>
#include <string.h>

#include "stability/lit_view.h"
#include "stability/shadow_measures.h"

// Texels of map on either side of an edge, together, that a method may get wrong. The mean for a texel's verdict is a
// quarter of a texel (the texel's middle is anywhere, up to half of one off), the most is half.
static double band_texels(ShadowMethod method, uint32_t kernel_px)
{
  if (method == SHADOWS_MAP) return 0.5;
  if (method == SHADOWS_PCF) return kernel_px + 1.0;
  return method == SHADOWS_PCSS ? 2 : 0;
}

// A floor of 40 m from just over it, slabs that float over it all along, the sun from the side; the sweep is the map's
// size.
Status measure_perspective_aliasing(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  LitView view = {0};
  ShadowOptions options = {.kernel_px = 3, .map_size_px = (uint32_t)point->value};
  uint32_t height = lab->quick ? 72 : 180;
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  scene_add_quad(&scene, white, vec3(-20, 0, 0), vec3(40, 0, 0), vec3(0, 0, -40));
  for (int i = 0; i < 24; i++) {
    double depth = 3 * pow(12, i / 23.0), x = (i % 5 - 2) * 0.3 * depth;
    Vec3 low = vec3(x, 2.6, -depth);
    scene_add_box(&scene, white, low, vec3_add(low, vec3(0.06 * depth, 0.05, 0.11 * depth)));
  }
  scene_add_light(&scene, light_directional(vec3(-0.35, -1, -0.2), M_PI));
  Camera camera = camera_perspective(vec3(0, 1.7, 1), vec3(0, 0.4, -8), 0.8);
  TRY(lit_view_make(&view, lab, &scene, &camera, height * 16 / 9, height, method, &options));
  TRY(lit_view_keep(&view, lab));
  point->measured = (double)lit_view_wrong(&view) / (double)lit_view_seen(&view);
  point->bound = lit_view_edge_pixels(&view, band_texels(method, options.kernel_px)) / (double)lit_view_seen(&view);
  point->warned = point->bound;

done:
  lit_view_free(&view);
  scene_free(&scene);
  return status;
}

// A wall that the light grazes, slabs before it; the sweep is the angle between both.
Status measure_projective_aliasing(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  LitView view = {0};
  uint32_t size = lab->quick ? 72 : 192;
  double angle = point->value * M_PI / 180;
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  scene_add_quad(&scene, white, vec3(-2, -2, 0), vec3(4, 0, 0), vec3(0, 4, 0));
  // Slabs whose shadows fall into view whatever the angle.
  for (int i = 0; i < 9; i++) {
    double before = 0.2, along = before / tan(angle);
    Vec3 shadow = vec3(i % 3 * 0.6 - 0.6, i / 3 * 0.55 - 0.5 + 0.03 * i, 0);
    Vec3 low = vec3_add(shadow, vec3(0.3 * along, along, before));
    scene_add_quad(&scene, white, low, vec3(0.2, 0.05, 0), vec3(-0.04, 0.25, 0));
  }
  Vec3 to_light = vec3(0.3 * cos(angle), cos(angle), sin(angle));
  scene_add_light(&scene, light_directional(vec3_neg(to_light), M_PI / sin(angle)));
  Camera camera = camera_orthographic(vec3(0, 0, 0.15), vec3(0, 0, 0), 1.1);
  TRY(lit_view_make(&view, lab, &scene, &camera, size, size, method, NULL));
  TRY(lit_view_keep(&view, lab));
  double seen = (double)lit_view_seen(&view), band = band_texels(method, 3);
  point->measured = (double)lit_view_wrong(&view) / seen;
  point->bound = (double)lit_view_edges(&view) * band / seen;
  point->warned = lit_view_edge_pixels(&view, band) / seen;

done:
  lit_view_free(&view);
  scene_free(&scene);
  return status;
}

// Pixels whose verdict is another one than a frame before.
static size_t changed(const float *now, const float *before, size_t pixels)
{
  size_t count = 0;
  for (size_t i = 0; i < pixels; i++) count += lab_differ((double)now[i], (double)before[i]);
  return count;
}

// Slabs over a floor in the sun, and a camera that drifts by a share of a texel a frame. What the map's edges change
// beyond what the true ones do: both sweep as many pixels where the map stands still in the world.
Status measure_shimmer(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  LitView view = {0};
  uint32_t size = lab->quick ? 64 : 128, frames = lab->quick ? 9 : 64;
  size_t pixels = (size_t)size * size, by_method = 0, by_rays = 0, seen = 0;
  const ShadowOptions options = {.kernel_px = 3, .map_size_px = 256};
  double texel_m = 0;
  float *before = malloc(2 * pixels * sizeof *before);
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  scene_add_quad(&scene, white, vec3(-20, 0, 20), vec3(40, 0, 0), vec3(0, 0, -40));
  for (int i = 0; i < 25; i++) {
    Vec3 low = vec3(i % 5 * 0.5 - 1.2 + 0.07 * (i / 5), 0.5, i / 5 * 0.5 - 1.2 - 0.05 * (i % 5));
    scene_add_quad(&scene, white, low, vec3(0.04, 0, 0.21), vec3(0.23, 0, -0.03));
  }
  scene_add_light(&scene, light_directional(vec3(-0.35, -1, -0.2), M_PI));
  if (!before) {
    status = log_no_memory(lab->log, "picture");
    goto done;
  }
  for (uint32_t frame = 0; frame < frames; frame++) {
    double moved = point->value * texel_m * frame;
    Vec3 eye = vec3(0.8 * moved, 0.4, 0.6 * moved);
    Camera camera = camera_orthographic(eye, vec3_sub(eye, vec3(0, 1, 0)), 1);
    TRY(lit_view_make(&view, lab, &scene, &camera, size, size, method, &options));
    if (frame == 0) texel_m = lit_view_texel_m(&view, vec3(0, 0, 0));
    if (texel_m == 0) texel_m = 2.0 / size;
    if (frame > 0) by_method += changed(view.lit, before, pixels);
    if (frame > 0) by_rays += changed(view.rays, before + pixels, pixels);
    memcpy(before, view.lit, pixels * sizeof *before);
    memcpy(before + pixels, view.rays, pixels * sizeof *before);
    seen += frame > 0 ? lit_view_seen(&view) : 0;
    if (frame + 1 == frames) TRY(lit_view_keep(&view, lab));
    lit_view_free(&view);
  }
  // A ramp changes all along its width, an edge where it is.
  double more = method == SHADOWS_PCF ? options.kernel_px + 1 : method == SHADOWS_PCSS ? 2 : 1;
  point->measured = fabs((double)by_method - (double)by_rays) / (double)seen;
  point->bound = point->warned = 3 * sqrt((double)(by_method + by_rays)) / (double)seen;
  (void)more;

done:
  lit_view_free(&view);
  free(before);
  scene_free(&scene);
  return status;
}

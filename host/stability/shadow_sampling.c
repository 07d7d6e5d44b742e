#include <stdio.h>
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

// What the method states beforehand of a view with one sample a pixel, as a share of the pixels seen.
static Status share_stated(double *share, Lab *lab, const LitView *view, const Camera *camera, ShadowMethod method,
                           const ShadowOptions *options)
{
  Status status = STATUS_OK;
  RenderSettings settings = lab_settings(view->truth.width, view->truth.height);
  settings.shadows = method;
  settings.shadow_options = *options;
  TRY(lab_shadow_bound(share, lab, &view->scene, camera, &settings));
  *share = fmin(*share / (double)lit_view_seen(view), 1);

done:
  return status;
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
  TRY(share_stated(&point->warned, lab, &view, &camera, method, &options));

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
  const ShadowOptions options = {.kernel_px = 3};
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
  TRY(lit_view_make(&view, lab, &scene, &camera, size, size, method, &options));
  TRY(lit_view_keep(&view, lab));
  double seen = (double)lit_view_seen(&view), band = band_texels(method, options.kernel_px);
  point->measured = (double)lit_view_wrong(&view) / seen;
  point->bound = (double)lit_view_edges(&view) * band / seen;
  TRY(share_stated(&point->warned, lab, &view, &camera, method, &options));

done:
  lit_view_free(&view);
  scene_free(&scene);
  return status;
}

// Pixels that differ from what stood there a frame before, when the camera was a pixel farther left.
static size_t changed(const float *now, const float *before, uint32_t width, uint32_t height)
{
  size_t count = 0;
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x + 1 < width; x++)
      count += lab_differ((double)now[y * width + x], (double)before[y * width + x + 1]);
  return count;
}

// Slabs over a floor in the sun, and a camera that drifts by a pixel a frame: what it sees is the same again, so that
// all that changes is the map. The sweep is the map's size: from two texels a frame to a sixteenth. Where one cascade
// ends and the next begins moves by whole texels, and with it what is looked up in which: strips a texel wide, one
// along x and one along y, in which edges of shadows are drawn otherwise.
Status measure_shimmer(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  // Pixels whose middle lies on a texel's edge go either way by rounding.
  static const double on_edges = 1e-3;
  Status status = STATUS_OK;
  LitView view = {0};
  uint32_t size = lab->quick ? 64 : 128, frames = lab->quick ? 9 : 64;
  size_t pixels = (size_t)size * size, by_method = 0, by_rays = 0;
  double seams_px = 0;
  const ShadowOptions options = {.kernel_px = 3, .map_size_px = (uint32_t)point->value};
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
    Vec3 eye = vec3(2.0 / size * frame, 0.4, 0);
    Camera camera = camera_orthographic(eye, vec3_sub(eye, vec3(0, 1, 0)), 1);
    TRY(lit_view_make(&view, lab, &scene, &camera, size, size, method, &options));
    if (frame > 0) by_method += changed(view.lit, before, size, size);
    if (frame > 0) by_rays += changed(view.rays, before + pixels, size, size);
    memcpy(before, view.lit, pixels * sizeof *before);
    memcpy(before + pixels, view.rays, pixels * sizeof *before);
    double texel_px = lit_view_texel_m(&view, eye) * size / 2;
    double at_edges = lit_view_edge_pixels(&view, band_texels(method, options.kernel_px)) / (double)pixels;
    if (frame > 0) seams_px += 2 * texel_px * size * fmin(at_edges, 1);
    if (frame + 1 == frames) TRY(lit_view_keep(&view, lab));
    lit_view_free(&view);
  }
  double all = (double)pixels * (frames - 1);
  point->measured = by_method > by_rays ? (double)(by_method - by_rays) / all : 0;
  point->bound = point->warned = on_edges + seams_px / all;

done:
  lit_view_free(&view);
  free(before);
  scene_free(&scene);
  return status;
}

#include "shared/aov.h"
#include "stability/lit_view.h"
#include "stability/shadow_measures.h"

// Wrong pixels that no edge explains, as a share of those seen.
static double share_off_edges(const LitView *view, ShadowMethod method, uint32_t kernel_px)
{
  return (double)lit_view_wrong_off_edges(view, shadow_reach_texels(method, kernel_px)) / (double)lit_view_seen(view);
}

// A floor that goes on past what a light's map sees: a spot light's cone, or, with an angle of 0, the sun's first
// cascade; floating boxes on either side of the rim.
Status measure_frustum_edge(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  LitView view = {0};
  uint32_t size = lab->quick ? 96 : 256;
  double outer = point->value * M_PI / 180, rim_m = outer > 0 ? fmin(tan(outer), 6) : 3;
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  scene_add_quad(&scene, white, vec3(-40, 0, 40), vec3(80, 0, 0), vec3(0, 0, -80));
  for (int i = 0; i < 12; i++) {
    double angle = i * M_PI / 6, at_m = rim_m * (0.5 + 0.08 * i);
    Vec3 center = vec3(at_m * cos(angle), 0.3, at_m * sin(angle));
    scene_add_box(&scene, white, vec3_sub(center, vec3(0.1, 0.1, 0.15)), vec3_add(center, vec3(0.12, 0.1, 0.1)));
  }
  if (outer > 0)
    scene_add_light(&scene, light_spot(vec3(0.02, 1, 0.01), vec3(0.02, 0, 0.01), 4 * M_PI, outer * 0.99, outer));
  else
    scene_add_light(&scene, light_directional(vec3(0.5, -1, 0.2), M_PI));
  Camera camera = outer > 0 ? camera_orthographic(vec3(0, 20, 0), vec3(0, 0, 0), 2.2 * rim_m)
                            : camera_perspective(vec3(0, 2, 6), vec3(0, 0, 0), 0.8);
  TRY(lit_view_make(&view, lab, &scene, &camera, size, size, method, NULL));
  TRY(lit_view_keep(&view, lab));
  point->measured = share_off_edges(&view, method, 3);

done:
  lit_view_free(&view);
  scene_free(&scene);
  return status;
}

// A speck at a light's back: a map has to begin at the light.
static void backdrop_add(Scene *scene, int material)
{
  scene_add_quad(scene, material, vec3(0, 0, 0.5), vec3(1e-3, 0, 0), vec3(0, 1e-3, 0));
}

// A plate `gap` before a screen that fills the light's view from `depth` on, in a scene that reaches to 1.
static Status gap_view_make(LitView *out, Lab *lab, double depth, double gap, ShadowMethod method)
{
  static const ShadowOptions options = {.kernel_px = 3, .map_size_px = 256};
  double plate = depth - gap;
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  backdrop_add(&scene, white);
  scene_add_quad(&scene, white, vec3(-1e-3, -1e-3, -1), vec3(2e-3, 0, 0), vec3(0, 2e-3, 0));
  scene_add_quad(&scene, white, vec3(-depth, -depth, -depth), vec3(2 * depth, 0, 0), vec3(0, 2 * depth, 0));
  scene_add_quad(&scene, white, vec3(-plate, -plate, -plate), vec3(plate, 0, 0), vec3(0, 2 * plate, 0));
  scene_add_light(&scene, light_spot(vec3(0, 0, 0), vec3(0, 0, -1), M_PI * depth * depth, 0.6, 0.7));
  // From between the plate and the screen.
  Camera camera = camera_orthographic(vec3(0, 0, -depth + 0.5 * gap), vec3(0, 0, -2), 0.4 * depth);
  camera.znear_m = 0;
  Status status = lit_view_make(out, lab, &scene, &camera, 32, 32, method, &options);
  scene_free(&scene);
  return status;
}

// The smallest gap that a shadow is seen across, by halves, as a share of the receiver's distance; the sweep is the
// ratio of the scene's reach to that distance.
Status measure_depth_range(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  LitView view = {0};
  double depth = 1 / point->value, share = 1, resolution = 0, map_depth = 0;
  for (double tried = 0.5; tried > 1e-7; tried *= 0.5) {
    TRY(gap_view_make(&view, lab, depth, tried * depth, method));
    TRY(lit_view_keep(&view, lab));
    bool resolved = lit_view_edges(&view) > 0 && share_off_edges(&view, method, 3) == 0;
    const RasterView *raster = &view.fit.views[0].raster;
    resolution = (double)view.fit.info.depth_slack * depth / fabs((double)raster->depth_by_w);
    map_depth = (double)raster->depth_far + (double)raster->depth_by_w / depth;
    lit_view_free(&view);
    if (!resolved) break;
    share = tried;
  }
  point->measured = share;
  // Slack of a depth in [0, 1], through depth = far + by_w / w; halves make it twice that. Rays have 64 roundings of
  // 2^-24 (lib/triangle.cl).
  point->bound = point->warned = fmax(2 * resolution, 128 * 0x1p-24);
  // Before the near plane all casters are at depth 0: passes/shadow_fit.h. Hybrid shadows have none.
  if (map_depth <= 0 && method != SHADOWS_HYBRID) point->warned = 1;

done:
  lit_view_free(&view);
  return status;
}

// A plate that stands so near to a spot light that a map may cut it off; the sweep is its distance as a share of the
// scene's reach.
Status measure_near_caster(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  LitView view = {0};
  uint32_t size = lab->quick ? 64 : 128;
  double plate = point->value;
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  backdrop_add(&scene, white);
  scene_add_quad(&scene, white, vec3(-1, -1, -1), vec3(2, 0, 0), vec3(0, 2, 0));
  scene_add_quad(&scene, white, vec3(-plate, -0.3 * plate, -plate), vec3(1.1 * plate, 0, 0), vec3(0, 0.5 * plate, 0));
  scene_add_light(&scene, light_spot(vec3(0, 0, 0), vec3(0, 0, -1), M_PI, 0.6, 0.7));
  Camera camera = camera_orthographic(vec3(0, 0, -0.5), vec3(0, 0, -1), 0.8);
  TRY(lit_view_make(&view, lab, &scene, &camera, size, size, method, NULL));
  TRY(lit_view_keep(&view, lab));
  point->measured = share_off_edges(&view, method, 3);

done:
  lit_view_free(&view);
  scene_free(&scene);
  return status;
}

// Floating boxes before and behind the camera, a lamp that passes from before it through it to behind it; and a spot
// light there that has half of them at its back.
Status measure_light_in_view(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  uint32_t size = lab->quick ? 64 : 192;
  const Vec3 lamp = {0.013, 0.021, -point->value};
  const Light lights[2] = {light_point(lamp, 8 * M_PI),
                           light_spot(lamp, vec3_add(lamp, vec3(0.4, 0, 1)), 8 * M_PI, 0.7, 0.8)};
  Camera camera = camera_perspective(vec3(0, 0, 0), vec3(0, 0, -1), 1.2);
  camera.znear_m = 0.1;
  double worst = -1;
  for (int kind = 0; kind < 2; kind++) {
    LitView view = {0};
    Scene scene = scene_empty();
    Material material = material_plain(vec3(1, 1, 1), 0, 1);
    material.double_sided = true;
    int white = scene_add_material(&scene, material);
    scene_add_box(&scene, white, vec3(-6, -3, -9), vec3(6, 3, 9));
    for (int i = 0; i < 16; i++) {
      Vec3 center = vec3(i % 4 * 1.7 - 2.4, i % 3 * 1.4 - 1.3, i * 0.9 - 7.3);
      scene_add_box(&scene, white, vec3_sub(center, vec3(0.2, 0.3, 0.2)), vec3_add(center, vec3(0.25, 0.2, 0.3)));
    }
    scene_add_light(&scene, lights[kind]);
    status = lit_view_make(&view, lab, &scene, &camera, size, size, method, NULL);
    double share = !status && lit_view_seen(&view) ? share_off_edges(&view, method, 3) : 0;
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

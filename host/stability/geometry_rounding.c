#include "shared/aov.h"
#include "stability/geometry_measures.h"

static double ulp(double value) { return (double)(nextafterf((float)value, INFINITY) - (float)value); }

static Vec3 same_along(double m) { return vec3(m, m, m); }

// Pixels that differ visibly from what the reference says of each, which is 1 where the scene is seen.
static size_t darkened(const Shot *shot, const float *reference)
{
  size_t count = 0;
  for (size_t i = 0; i < shot_pixels(shot); i++)
    count += lab_differ((double)shot->radiance[4 * i], reference ? (double)reference[4 * i] : 1);
  return count;
}

// A level floor of 12 x 12 quads, moved by the point's value along each axis: in light that grazes it nothing is dark,
// and as a mirror in an even environment, seen at a slant, it shows that.
Status measure_self_hits(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  enum { CELLS = 12 };
  static const double slants[3] = {0.5, 0.05, 0.005};
  Status status = STATUS_OK;
  uint32_t size = lab->quick ? 48 : 160;
  size_t dark = 0, all = 0;
  Vec3 moved = same_along(point->value), up = vec3(0, 1, 0);
  for (int i = 0; i < 6; i++) {
    Shot by_rays = {0}, open = {0};
    bool mirror = i % 2;
    double slant = slants[i / 2];
    Scene scene = scene_empty();
    Material material = mirror ? material_plain(vec3(1, 1, 1), 1, 0) : material_plain(vec3(1, 1, 1), 0, 1);
    int floor_material = scene_add_material(&scene, material);
    for (int k = 0; k < CELLS * CELLS; k++) {
      Vec3 corner = vec3_add(moved, vec3(k % CELLS - CELLS / 2, 0, k / CELLS - CELLS / 2 + 1));
      scene_add_quad(&scene, floor_material, corner, vec3(1, 0, 0), vec3(0, 0, -1));
    }
    if (mirror)
      scene_set_constant(&scene, 1, 1, 1);
    else
      scene_add_light(&scene,
                      light_directional(vec3(-cos(slant) * 0.8, -sin(slant), -cos(slant) * 0.6), M_PI / sin(slant)));
    Vec3 eye = vec3_add(moved, mirror ? vec3(0.3, 8 * sin(slant), 8 * cos(slant)) : vec3(0, 8, 0));
    Camera camera = camera_perspective(eye, mirror ? vec3_add(moved, vec3(0, 0, 0)) : vec3_sub(eye, up), 0.5);
    RenderSettings settings = lab_settings(size, size);
    if (mirror) settings.reflections = REFLECTIONS_RAYS;
    status = lab_render_scene(&by_rays, lab, &scene, &camera, &settings);
    settings.shadows = SHADOWS_NONE;
    if (!status && !mirror) status = lab_render_scene(&open, lab, &scene, &camera, &settings);
    if (!status) dark += darkened(&by_rays, mirror ? NULL : open.radiance);
    if (!status) all += shot_pixels(&by_rays);
    if (!status && i == 0) status = lab_keep(lab, by_rays.radiance, open.radiance, size, size, 4);
    shot_free(&by_rays);
    shot_free(&open);
    scene_free(&scene);
    if (status) break;
  }
  point->measured = all ? (double)dark / (double)all : NAN;
  return status;
}

// What the start of a shadow ray is moved by along a normal, as a share of the distance from the origin: POSITION_ERROR
// of lib/surface.cl.
static const double start_moved = 8.4e-7;

// Is the floor in shadow under a plate that hangs `gap` over it, over half of what is seen?
static Status contact_is_kept(bool *kept, Lab *lab, double moved, double gap)
{
  enum { SIZE = 32 };
  Shot shot = {0};
  Vec3 at = same_along(moved);
  Scene scene = scene_empty();
  Material material = material_plain(vec3(1, 1, 1), 0, 1);
  int white = scene_add_material(&scene, material);
  scene_add_quad(&scene, white, vec3_add(at, vec3(-2, 0, 2)), vec3(4, 0, 0), vec3(0, 0, -4));
  scene_add_quad(&scene, white, vec3_add(at, vec3(-2, gap, 2)), vec3(2, 0, 0), vec3(0, 0, -4));
  scene_add_light(&scene, light_directional(vec3(0.2, -1, 0.3), M_PI));
  // From between both.
  Camera camera = camera_orthographic(vec3_add(at, vec3(0, gap / 2, 0)), vec3_add(at, vec3(0, gap / 2 - 1, 0)), 1);
  camera.znear_m = 0;
  RenderSettings settings = lab_settings(SIZE, SIZE);
  Status status = lab_render_scene(&shot, lab, &scene, &camera, &settings);
  *kept = true;
  for (int i = 0; i < SIZE * SIZE && !status; i++) {
    double x = (i % SIZE + 0.5) * 2 / SIZE - 1, slack_m = 0.07 + 0.2 * gap;
    if (x < -slack_m) *kept &= shot.radiance[4 * i] == 0;
    if (x > slack_m) *kept &= shot.radiance[4 * i] > 0;
  }
  shot_free(&shot);
  scene_free(&scene);
  return status;
}

// The least gap, in ulps of where the floor is, at which a plate over it still shadows it.
Status measure_contact(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const double vertices_m = 2.83, roundings = 64 * 0x1p-24;  // lib/triangle.cl
  Status status = STATUS_OK;
  double step = ulp(fmax(point->value, 1)), gap = exp2(floor(log2(fmin(1 / step, 4096))));
  bool kept = true;
  while (gap >= 2 && kept) {
    TRY(contact_is_kept(&kept, lab, point->value, gap * step));
    if (kept) gap /= 2;
  }
  point->measured = 2 * gap;
  point->bound = 2 * (2 + (start_moved * point->value + roundings * vertices_m) / step);
  point->warned = point->bound;

done:
  return status;
}

// Boxes and a ball on a floor with a lamp, and its camera, times `scale`, moved along each axis.
static Status boxes_render(Shot *out, Lab *lab, double scale, double moved)
{
  uint32_t size = lab->quick ? 64 : 192;
  Vec3 at = same_along(moved);
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(0.7, 0.7, 0.7), 0, 1)),
      mirror = scene_add_material(&scene, material_plain(vec3(0.9, 0.9, 0.9), 1, 0));
#define AT(x, y, z) vec3_add(at, vec3((x)*scale, (y)*scale, (z)*scale))
  scene_add_quad(&scene, white, AT(-3, 0, 3), vec3(6 * scale, 0, 0), vec3(0, 0, -6 * scale));
  scene_add_box(&scene, white, AT(-1.25, 0, -0.5), AT(-0.375, 1, 0.25));
  scene_add_box(&scene, white, AT(0.75, 0, 0.5), AT(1.25, 0.5, 1));
  scene_add_sphere(&scene, mirror, AT(0.25, 0.5, -0.5), 0.5 * scale, 16);
  scene_add_light(&scene, light_point(AT(1.5, 3, 2), 12 * scale * scale));
  Camera camera = camera_perspective(AT(0, 2.5, 5), AT(0, 0.25, 0), 0.7);
#undef AT
  camera.znear_m = 0.01 * scale;
  RenderSettings settings = lab_settings(size, size);
  settings.reflections = REFLECTIONS_RAYS;
  Status status = lab_render_scene(out, lab, &scene, &camera, &settings);
  scene_free(&scene);
  return status;
}

Status measure_scale(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  Shot unit = {0}, scaled = {0};
  TRY(boxes_render(&unit, lab, 1, 0));
  TRY(boxes_render(&scaled, lab, exp2(point->value), 0));
  TRY(lab_keep(lab, scaled.radiance, unit.radiance, unit.width, unit.height, 4));
  point->measured = (double)lab_count_different(&scaled, &unit) / (double)shot_pixels(&unit);

done:
  shot_free(&unit);
  shot_free(&scaled);
  return status;
}

// Neighbouring pixels that differ visibly: what a shift of a pixel changes at most.
static size_t contrasts(const Shot *shot)
{
  size_t count = 0;
  for (size_t i = 0; i < shot_pixels(shot); i++) {
    const float *at = shot->radiance + 4 * i;
    if (i % shot->width + 1 < shot->width) count += lab_differ((double)at[0], (double)at[4]);
    if (i / shot->width + 1 < shot->height) count += lab_differ((double)at[0], (double)at[4 * shot->width]);
  }
  return count;
}

// Pixels whose light changes visibly where its way from the lamp becomes `shift_m` shorter, at most by shift / height
// of the lamp over the surface and 3 shift / distance of E = I height / distance^3.
static size_t shaded_otherwise(const Shot *shot, Vec3 lamp, double shift_m)
{
  size_t count = 0;
  for (size_t i = 0; i < shot_pixels(shot); i++) {
    if (shot->ids[i] == AOV_NONE) continue;
    Vec3 to_lamp = vec3_sub(lamp, shot_vector(shot, i, AOV_POSITION));
    double height = vec3_dot(to_lamp, shot_vector(shot, i, AOV_NORMAL)), radiance = shot->radiance[4 * i];
    double share = 3 * shift_m / vec3_length(to_lamp) + (height > 0 ? shift_m / height : 0);
    count += lab_differ(radiance, radiance * (1 + share));
  }
  return count;
}

// Vertices, lamp and camera are each rounded by up to half an ulp of where they are along three axes, and the start of
// a shadow ray, from which its light is reckoned, is moved along the normal.
Status measure_move(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const double nearest_m = 4;  // what the camera sees is no nearer
  Status status = STATUS_OK;
  Shot unit = {0}, moved = {0};
  TRY(boxes_render(&unit, lab, 1, 0));
  TRY(boxes_render(&moved, lab, 1, point->value));
  TRY(lab_keep(lab, moved.radiance, unit.radiance, unit.width, unit.height, 4));
  double pixels = (double)shot_pixels(&unit), rounded_m = sqrt(3) * ulp(point->value + 5);
  double start_m = rounded_m + sqrt(3) * start_moved * point->value;
  double edges_px = (double)contrasts(&unit) * (rounded_m + start_m) / ((double)unit.camera.scale * nearest_m);
  double shaded_px = (double)shaded_otherwise(&unit, vec3(1.5, 3, 2), start_m);
  point->measured = (double)lab_count_different(&moved, &unit) / pixels;
  point->bound = point->warned = fmin((edges_px + shaded_px) / pixels + 1e-3, 1);

done:
  shot_free(&unit);
  shot_free(&moved);
  return status;
}

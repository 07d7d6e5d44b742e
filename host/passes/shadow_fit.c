#include "passes/shadow_fit.h"

#include <stdlib.h>

#include "shared/raster.h"

static const double spot_widest = 1.7320508;                // tangent of half of 120 degrees
static const double near_share = 1e-3, least_share = 1e-8;  // of the greatest depth
static const double depth_rounding = 8 / 16777216.0;        // of depths in [0, 1]
// Of a texel: what a bent surface is given, and more for a wider kernel. Found by trial on fluted columns, hills and a
// room: by nearest texels 17, 5, 6 and 7 % of the columns' pixels are wrong at 0, 1/2, 1 and 3/2 texels.
static const float slope_px = 0.25f;
static const uint32_t texels_most = 1u << 24;  // of a light
enum { CASCADES_MOST = 3, GRID = 6 };

static Vec3 wide(Float3 v) { return vec3(v.x, v.y, v.z); }
static Float3 narrow(Vec3 v) { return (Float3){(float)v.x, (float)v.y, (float)v.z}; }

static Vec3 box_corner(const ShadowScope *scope, int i)
{
  return vec3(i & 1 ? scope->high.x : scope->low.x, i & 2 ? scope->high.y : scope->low.y,
              i & 4 ? scope->high.z : scope->low.z);
}

// A right-handed frame about `forward`.
typedef struct Axes {
  Vec3 right, down, forward;
} Axes;

static Axes axes_about(Vec3 forward)
{
  Vec3 helper = fabs(forward.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0);
  Vec3 right = vec3_unit_or(vec3_cross(forward, helper), vec3(1, 0, 0));
  return (Axes){right, vec3_cross(forward, right), forward};
}

static void row_set(Mat4 *m, int row, Vec3 v, double last)
{
  m->m[row] = v.x;
  m->m[4 + row] = v.y;
  m->m[8 + row] = v.z;
  m->m[12 + row] = last;
}

// Sees directions up to `tangent` to each side of the axis, from `eye`.
static ShadowView view_perspective(Vec3 eye, Axes axes, double tangent, double near_m, double far_m, uint32_t size_px)
{
  Mat4 m;
  const Vec3 forward = axes.forward;
  double scale = 0.5 / tangent, depth = far_m / (far_m - near_m);
  Vec3 x = vec3_add(vec3_scale(axes.right, scale), vec3_scale(forward, 0.5));
  Vec3 y = vec3_add(vec3_scale(axes.down, scale), vec3_scale(forward, 0.5));
  row_set(&m, 0, x, -vec3_dot(x, eye));
  row_set(&m, 1, y, -vec3_dot(y, eye));
  row_set(&m, 2, vec3_scale(forward, depth), -depth * (vec3_dot(forward, eye) + near_m));
  row_set(&m, 3, forward, -vec3_dot(forward, eye));
  Vec3 corner = vec3_sub(forward, vec3_scale(vec3_add(axes.right, axes.down), tangent));
  return (ShadowView){
      .raster = raster_view_of_map(&m, eye, size_px, least_share * far_m),
      .sight_0 = narrow(corner),
      .sight_x = narrow(vec3_scale(axes.right, 2 * tangent / size_px)),
      .sight_y = narrow(vec3_scale(axes.down, 2 * tangent / size_px)),
  };
}

// Sees the square of `side_m` about `center`, seen along the axis from `near_m` to `far_m` of it.
static ShadowView view_parallel(Vec3 center, Axes axes, double side_m, double near_m, double far_m, uint32_t size_px)
{
  Mat4 m;
  double depth = far_m - near_m;
  Vec3 x = vec3_scale(axes.right, 1 / side_m), y = vec3_scale(axes.down, 1 / side_m);
  Vec3 z = vec3_scale(axes.forward, 1 / depth);
  row_set(&m, 0, x, 0.5 - vec3_dot(x, center));
  row_set(&m, 1, y, 0.5 - vec3_dot(y, center));
  row_set(&m, 2, z, -(vec3_dot(axes.forward, center) + near_m) / depth);
  row_set(&m, 3, vec3(0, 0, 0), 1);
  Vec3 corner = vec3_sub(vec3_scale(axes.forward, near_m), vec3_scale(vec3_add(axes.right, axes.down), side_m / 2));
  return (ShadowView){
      .raster = raster_view_of_map(&m, center, size_px, 0),
      .sight_0 = narrow(corner),
      .sight_x = narrow(vec3_scale(axes.right, side_m / size_px)),
      .sight_y = narrow(vec3_scale(axes.down, side_m / size_px)),
      .axis = narrow(vec3_scale(axes.forward, depth)),
  };
}

static int double_compare(const void *a, const void *b)
{
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static uint32_t power_of_two_from(double least, uint32_t most)
{
  uint32_t size = SHADOW_MAP_LEAST_PX;
  while (size < most && size < least) size *= 2;
  return size;
}

// Side of a pixel at a point, in metres; 0 where the camera does not see it.
static double pixel_at(const CameraInfo *camera, Vec3 point)
{
  Vec3 a = vec3_sub(point, wide(camera->position));
  double depth = vec3_dot(a, wide(camera->forward));
  if (depth <= camera->near_m || depth > camera->far_m) return 0;
  double w = camera->orthographic ? 1 : depth;
  double x = (vec3_dot(a, wide(camera->right)) / w + camera->center_x) / camera->scale - camera->crop_x;
  double y = (vec3_dot(a, wide(camera->down)) / w + camera->center_y) / camera->scale - camera->crop_y;
  return x < 0 || y < 0 || x > camera->width || y > camera->height ? 0 : w * camera->scale;
}

// Size at which the median point's texel is a pixel wide; a texel is texel_per_m wide for each metre from the light, in
// a map of one texel.
static double size_by_magnification(const ShadowScope *scope, Vec3 light, double texel_per_m)
{
  double sizes[GRID * GRID * GRID];
  int count = 0;
  Vec3 step = vec3_scale(vec3_sub(scope->high, scope->low), 1.0 / GRID);
  for (int i = 0; i < GRID * GRID * GRID; i++) {
    Vec3 at = vec3(i % GRID + 0.5, i / GRID % GRID + 0.5, i / (GRID * GRID) + 0.5);
    Vec3 point = vec3_add(scope->low, vec3_mul(step, at));
    double pixel_m = pixel_at(scope->camera, point);
    if (pixel_m > 0) sizes[count++] = vec3_length(vec3_sub(point, light)) * texel_per_m / pixel_m;
  }
  if (count == 0) return 0;
  qsort(sizes, (size_t)count, sizeof *sizes, double_compare);
  return sizes[count / 2];
}

static uint32_t size_choose(const ShadowOptions *options, double wanted, uint32_t views)
{
  uint32_t most = options->map_size_px ? options->map_size_px : SHADOW_MAP_MOST_PX;
  uint32_t size = options->map_size_px ? options->map_size_px : power_of_two_from(wanted, most);
  while (size > SHADOW_MAP_LEAST_PX && !options->map_size_px && (uint64_t)size * size * views > texels_most) size /= 2;
  return size;
}

static void local_light_fit(ShadowFit *fit, const LightInfo *light, const ShadowOptions *options,
                            const ShadowScope *scope)
{
  static const Vec3 faces[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  ShadowInfo *info = &fit->info;
  Vec3 eye = wide(light->position);
  double farthest = 0, nearest = INFINITY, tangent = 1;
  for (int i = 0; i < 8; i++) {
    Vec3 corner = vec3_sub(box_corner(scope, i), eye);
    farthest = fmax(farthest, vec3_length(corner));
    nearest = fmin(nearest, vec3_dot(corner, wide(light->direction)));
  }
  farthest = fmax(fmin(farthest, light->range_m), 1e-30);
  bool spot = light->kind == LIGHT_KIND_SPOT;
  if (spot) {
    double cosine = -(double)light->spot_offset / light->spot_scale;
    tangent = cosine > 0 ? sqrt(1 - cosine * cosine) / cosine : INFINITY;
    spot = tangent <= spot_widest;
  }
  info->views = spot ? SHADOW_VIEWS_ONE : SHADOW_VIEWS_CUBE;
  info->view_count = spot ? 1 : 6;
  if (!spot) tangent = 1;
  double near_m = near_share * farthest;
  if (spot) near_m = fmin(fmax(near_m, 0.9 * nearest), 0.9 * farthest);
  info->size_px = size_choose(options, size_by_magnification(scope, eye, 2 * tangent), info->view_count);
  if (info->size_px <= 2 * info->gutter_px) info->gutter_px = info->size_px / 2 - 1;
  tangent *= info->size_px / (double)(info->size_px - 2 * info->gutter_px);
  for (uint32_t i = 0; i < info->view_count; i++)
    fit->views[i] = view_perspective(eye, axes_about(spot ? wide(light->direction) : faces[i]), tangent, near_m,
                                     farthest * 1.001, info->size_px);
  info->radius = options->light_radius_m;
  info->depth_slack = (float)depth_rounding;
}

// Bounds along three axes.
typedef struct AxisBox {
  double low[3], high[3];
} AxisBox;

static void axis_box_add(AxisBox *box, Axes axes, Vec3 point)
{
  double at[3] = {vec3_dot(point, axes.right), vec3_dot(point, axes.down), vec3_dot(point, axes.forward)};
  for (int i = 0; i < 3; i++) {
    box->low[i] = fmin(box->low[i], at[i]);
    box->high[i] = fmax(box->high[i], at[i]);
  }
}

static AxisBox axis_box_empty(void)
{
  return (AxisBox){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

// What the camera sees between two depths.
static AxisBox slice_box(const CameraInfo *camera, double near_m, double far_m, Axes axes)
{
  AxisBox box = axis_box_empty();
  for (int i = 0; i < 8; i++) {
    double depth = i & 4 ? far_m : near_m, w = camera->orthographic ? 1 : depth;
    double x = ((i & 1 ? camera->width : 0) + camera->crop_x) * (double)camera->scale - camera->center_x;
    double y = ((i & 2 ? camera->height : 0) + camera->crop_y) * (double)camera->scale - camera->center_y;
    Vec3 point = vec3_add(wide(camera->position), vec3_scale(wide(camera->forward), depth));
    point = vec3_add(point, vec3_scale(wide(camera->right), x * w));
    axis_box_add(&box, axes, vec3_add(point, vec3_scale(wide(camera->down), y * w)));
  }
  return box;
}

static double box_side(const AxisBox *box)
{
  return fmax(fmax(box->high[0] - box->low[0], box->high[1] - box->low[1]), 1e-30);
}

// A square map of the box, whose corner lies on a whole texel.
static ShadowView cascade_view(const AxisBox *box, const AxisBox *whole, Axes axes, const ShadowInfo *info)
{
  double side = box_side(box) * info->size_px / (info->size_px - 2.0 * info->gutter_px - 1);
  double texel = side / info->size_px;
  double x = round((box->low[0] + box->high[0]) / 2 / texel) * texel,
         y = round((box->low[1] + box->high[1]) / 2 / texel) * texel;
  double margin = 1e-3 * fmax(whole->high[2] - whole->low[2], 1e-30);
  Vec3 center = vec3_add(vec3_scale(axes.right, x), vec3_scale(axes.down, y));
  double middle = (whole->low[2] + whole->high[2]) / 2;
  center = vec3_add(center, vec3_scale(axes.forward, middle));
  return view_parallel(center, axes, side, whole->low[2] - margin - middle, whole->high[2] + margin - middle,
                       info->size_px);
}

// Depths that the camera sees of the scene.
static void visible_depths(double *near_m, double *far_m, const ShadowScope *scope)
{
  const CameraInfo *camera = scope->camera;
  *near_m = INFINITY;
  *far_m = -INFINITY;
  for (int i = 0; i < 8; i++) {
    double depth = vec3_dot(vec3_sub(box_corner(scope, i), wide(camera->position)), wide(camera->forward));
    *near_m = fmin(*near_m, depth);
    *far_m = fmax(*far_m, depth);
  }
  *far_m = fmax(fmin(*far_m, camera->far_m), 1e-30);
  *near_m = fmin(fmax(*near_m, fmax(camera->near_m, 1e-3 * *far_m)), *far_m);
}

static void directional_light_fit(ShadowFit *fit, const LightInfo *light, const ShadowOptions *options,
                                  const ShadowScope *scope)
{
  ShadowInfo *info = &fit->info;
  Axes axes = axes_about(wide(light->direction));
  AxisBox whole = axis_box_empty(), boxes[CASCADES_MOST + 1];
  for (int i = 0; i < 8; i++) axis_box_add(&whole, axes, box_corner(scope, i));
  double near_m, far_m;
  uint32_t count = 0;
  visible_depths(&near_m, &far_m, scope);
  for (int i = 0; i < CASCADES_MOST; i++) {
    // Halfway between splits by equal ratios and by equal depths.
    double share = (i + 1.0) / CASCADES_MOST,
           end = (near_m * pow(far_m / near_m, share) + near_m + (far_m - near_m) * share) / 2;
    AxisBox box = slice_box(scope->camera, near_m, end, axes);
    for (int axis = 0; axis < 2; axis++) {
      box.low[axis] = fmin(fmax(box.low[axis], whole.low[axis]), whole.high[axis]);
      box.high[axis] = fmax(fmin(box.high[axis], whole.high[axis]), whole.low[axis]);
    }
    if (box_side(&box) < 0.7 * box_side(&whole)) boxes[count++] = box;
  }
  boxes[count++] = whole;
  double pixels = fmax(scope->camera->width, scope->camera->height);
  info->views = SHADOW_VIEWS_CASCADES;
  info->view_count = count;
  info->size_px = size_choose(options, pixels, count);
  if (info->size_px <= 2 * info->gutter_px + 2) info->gutter_px = info->size_px / 2 - 2;
  for (uint32_t i = 0; i < count; i++) fit->views[i] = cascade_view(&boxes[i], &whole, axes, info);
  double depth_m = vec3_length(wide(fit->views[0].axis));
  info->radius = (float)(tan(options->light_angle_rad) * depth_m);
  info->depth_slack = (float)depth_rounding;
}

bool shadow_fit(ShadowFit *out, const LightInfo *light, ShadowMethod method, const ShadowOptions *options,
                const ShadowScope *scope)
{
  float brightest = fmaxf(fmaxf(light->radiant.x, light->radiant.y), light->radiant.z);
  *out = (ShadowFit){.info = {.kernel_px = 1}};
  if (!(brightest > 0) || !vec3_is_finite(wide(light->position))) return false;
  ShadowInfo *info = &out->info;
  info->method = method == SHADOWS_PCSS     ? SHADOW_BY_PCSS
                 : method == SHADOWS_PCF    ? SHADOW_BY_PCF
                 : method == SHADOWS_HYBRID ? SHADOW_BY_TRIANGLES
                                            : SHADOW_BY_TEXEL;
  if (method == SHADOWS_PCF) info->kernel_px = options->kernel_px;
  info->slope_px = slope_px * (float)(1 + (method == SHADOWS_PCSS ? 3 : info->kernel_px)) + 2.0f / RASTER_SNAP;
  info->gutter_px = method == SHADOWS_PCSS     ? SHADOW_DISC_PX + 1
                    : method == SHADOWS_HYBRID ? 0
                                               : info->kernel_px / 2 + 2;
  if (light->kind == LIGHT_KIND_DIRECTIONAL)
    directional_light_fit(out, light, options, scope);
  else
    local_light_fit(out, light, options, scope);
  return true;
}

#include "stability/lit_view.h"

#include <stdlib.h>

#include "device/fault.h"
#include "shared/aov.h"

static Vec3 wide(Float3 v) { return vec3(v.x, v.y, v.z); }

static double row_dot(Float4 row, Vec3 v)
{
  return (double)row.x * v.x + (double)row.y * v.y + (double)row.z * v.z + (double)row.w;
}

void lit_view_free(LitView *view)
{
  device_scene_free(&view->scene);
  shot_free(&view->truth);
  free(view->lit);
  free(view->rays);
  free(view->seen);
  free(view->edges);
  *view = (LitView){0};
}

// A measurement gone wrong on demand: a fifth of the method's pixels, inverted.
static void lit_corrupt(float *lit, size_t pixels)
{
  for (size_t i = pixels / 5 * 2; i < pixels / 5 * 3; i++) lit[i] = 1 - lit[i];
}

static void shares_fill(LitView *view, const Shot *open, const Shot *method)
{
  for (size_t i = 0; i < shot_pixels(open); i++) {
    float all = open->radiance[4 * i];
    view->seen[i] = all > 0;
    view->lit[i] = view->seen[i] ? method->radiance[4 * i] / all : 0;
    view->rays[i] = view->seen[i] ? view->truth.radiance[4 * i] / all : 0;
  }
  if (fault_due("stability")) lit_corrupt(view->lit, shot_pixels(open));
}

static bool same_plane(const LitView *view, size_t a, size_t b)
{
  const Shot *shot = &view->truth;
  if (shot->ids[AOV_OBJECT * shot_pixels(shot) + a] != shot->ids[AOV_OBJECT * shot_pixels(shot) + b]) return false;
  return vec3_dot(shot_vector(shot, a, AOV_NORMAL), shot_vector(shot, b, AOV_NORMAL)) > 0.999;
}

static int edge_between(const LitView *view, size_t a, size_t b, int edge, int end)
{
  if (!view->seen[a] && !view->seen[b]) return 0;
  if (!view->seen[a] || !view->seen[b] || !same_plane(view, a, b)) return end;
  return (view->rays[a] > 0.5f) == (view->rays[b] > 0.5f) ? 0 : edge;
}

static void edges_find(LitView *view)
{
  uint32_t width = view->truth.width, height = view->truth.height;
  for (size_t i = 0; i < shot_pixels(&view->truth); i++) {
    int row = i % width + 1 < width ? edge_between(view, i, i + 1, EDGE_ROW, END_ROW) : 0;
    int column = i / width + 1 < height ? edge_between(view, i, i + width, EDGE_COLUMN, END_COLUMN) : 0;
    view->edges[i] = (uint8_t)(row | column);
  }
}

Status lit_view_make(LitView *out, Lab *lab, const Scene *scene, const Camera *camera, uint32_t width, uint32_t height,
                     ShadowMethod method, const ShadowOptions *options)
{
  Status status = STATUS_OK;
  LitView view = {0};
  Shot open = {0}, by_method = {0};
  size_t pixels = (size_t)width * height;
  RenderSettings settings = lab_settings(width, height);
  if (options) settings.shadow_options = *options;
  TRY(scene_check_complete(scene, lab->log));
  TRY(device_scene_make(&view.scene, lab->device, scene, NULL, lab->log));
  TRY(lab_render(&view.truth, lab, &view.scene, camera, &settings));
  settings.shadows = SHADOWS_NONE;
  TRY(lab_render(&open, lab, &view.scene, camera, &settings));
  settings.shadows = method;
  TRY(lab_render(&by_method, lab, &view.scene, camera, &settings));
  view.lit = calloc(pixels, sizeof *view.lit);
  view.rays = calloc(pixels, sizeof *view.rays);
  view.seen = calloc(pixels, sizeof *view.seen);
  view.edges = calloc(pixels, sizeof *view.edges);
  if (!view.lit || !view.rays || !view.seen || !view.edges) {
    status = log_no_memory(lab->log, "picture");
    goto done;
  }
  shares_fill(&view, &open, &by_method);
  edges_find(&view);
  const ShadowScope scope = {&view.truth.camera, view.scene.low, view.scene.high};
  view.fitted = method >= SHADOWS_MAP && method <= SHADOWS_HYBRID &&
                shadow_fit(&view.fit, &view.scene.light_infos[0], method, &settings.shadow_options, &scope);
  *out = view;
  view = (LitView){0};

done:
  lit_view_free(&view);
  shot_free(&open);
  shot_free(&by_method);
  return status;
}

size_t lit_view_seen(const LitView *view)
{
  size_t count = 0;
  for (size_t i = 0; i < shot_pixels(&view->truth); i++) count += view->seen[i];
  return count;
}

bool lit_view_is_wrong(const LitView *view, size_t pixel)
{
  return view->seen[pixel] && lab_differ((double)view->lit[pixel], (double)view->rays[pixel]);
}

size_t lit_view_wrong(const LitView *view)
{
  size_t count = 0;
  for (size_t i = 0; i < shot_pixels(&view->truth); i++) count += lit_view_is_wrong(view, i);
  return count;
}

Status lit_view_keep(const LitView *view, Lab *lab)
{
  return lab_keep(lab, view->lit, view->rays, view->truth.width, view->truth.height, 1);
}

// Texel coordinates of a point in a view; false where it does not lie before the eye plane.
static bool map_point(double out[2], const ShadowView *view, Vec3 point)
{
  Vec3 a = vec3_sub(point, wide(view->raster.origin));
  double w = view->raster.parallel ? 1 : row_dot(view->raster.w, a);
  out[0] = row_dot(view->raster.x, a) / w;
  out[1] = row_dot(view->raster.y, a) / w;
  return w > 0;
}

static int largest_component(Vec3 a)
{
  double x = fabs(a.x), y = fabs(a.y), z = fabs(a.z);
  if (x >= y && x >= z) return a.x < 0 ? 1 : 0;
  return y >= z ? (a.y < 0 ? 3 : 2) : a.z < 0 ? 5 : 4;
}

// The view that a point is looked up in, by the rule of SHADOW_VIEWS_*; NULL for none.
static const ShadowView *map_view(const LitView *view, Vec3 point)
{
  const ShadowInfo *info = &view->fit.info;
  const ShadowView *views = view->fit.views;
  double at[2], low = info->gutter_px, high = (double)info->size_px - info->gutter_px;
  if (!view->fitted) return NULL;
  if (info->views == SHADOW_VIEWS_CUBE) return &views[largest_component(vec3_sub(point, wide(views[0].raster.origin)))];
  for (uint32_t i = 0; i < info->view_count; i++)
    if (map_point(at, &views[i], point) && at[0] >= low && at[0] <= high && at[1] >= low && at[1] <= high)
      return &views[i];
  return NULL;
}

// Where the camera's ray through a point of the picture (pixels, from the top left) meets a plane.
static Vec3 plane_point(const CameraInfo *camera, double x, double y, Vec3 on_plane, Vec3 normal)
{
  double right = x * (double)camera->scale - (double)camera->center_x,
         down = y * (double)camera->scale - (double)camera->center_y;
  Vec3 across = vec3_add(vec3_scale(wide(camera->right), right), vec3_scale(wide(camera->down), down));
  Vec3 origin = wide(camera->position), direction = wide(camera->forward);
  if (camera->orthographic)
    origin = vec3_add(origin, across);
  else
    direction = vec3_add(direction, across);
  double t = vec3_dot(normal, vec3_sub(on_plane, origin)) / vec3_dot(normal, direction);
  return vec3_add(origin, vec3_scale(direction, t));
}

bool lit_view_footprint(Footprint *out, const LitView *view, size_t pixel)
{
  const CameraInfo *camera = &view->truth.camera;
  Vec3 point = shot_vector(&view->truth, pixel, AOV_POSITION), normal = shot_vector(&view->truth, pixel, AOV_NORMAL);
  const ShadowView *map = map_view(view, point);
  double x = (double)(pixel % view->truth.width) + 0.5, y = (double)(pixel / view->truth.width) + 0.5;
  double left[2], right[2], above[2], below[2];
  if (!map || !map_point(left, map, plane_point(camera, x - 0.25, y, point, normal)) ||
      !map_point(right, map, plane_point(camera, x + 0.25, y, point, normal)) ||
      !map_point(above, map, plane_point(camera, x, y - 0.25, point, normal)) ||
      !map_point(below, map, plane_point(camera, x, y + 0.25, point, normal)))
    return false;
  double by_x[2] = {2 * (right[0] - left[0]), 2 * (right[1] - left[1])};  // texels a pixel
  double by_y[2] = {2 * (below[0] - above[0]), 2 * (below[1] - above[1])};
  double determinant = by_x[0] * by_y[1] - by_y[0] * by_x[1];
  *out = (Footprint){{by_y[1] / determinant, -by_x[1] / determinant}, {-by_y[0] / determinant, by_x[0] / determinant}};
  return isfinite(out->x[0]) && isfinite(out->x[1]) && isfinite(out->y[0]) && isfinite(out->y[1]);
}

double footprint_length(const Footprint *footprint)
{
  return fmax(hypot(footprint->x[0], footprint->x[1]), hypot(footprint->y[0], footprint->y[1]));
}

static bool edge_at(const LitView *view, size_t pixel, int axis)
{
  return view->edges[pixel] >> axis & 1;
}  // EDGE_ROW, EDGE_COLUMN

// Sum over the pixels whose edges have that bit, or for columns the next.
static double band_pixels(const LitView *view, double texels, int row_bit)
{
  double sum = 0;
  for (size_t i = 0; i < shot_pixels(&view->truth); i++) {
    Footprint footprint;
    int bits = view->edges[i] / row_bit & 3;
    if (!bits || !lit_view_footprint(&footprint, view, i)) continue;
    for (int axis = 0; axis < 2; axis++)
      if (bits >> axis & 1) sum += texels * (fabs(footprint.x[axis]) + fabs(footprint.y[axis]));
  }
  return sum;
}

double lit_view_edge_pixels(const LitView *view, double texels) { return band_pixels(view, texels, EDGE_ROW); }
double lit_view_end_pixels(const LitView *view, double texels) { return band_pixels(view, texels, END_ROW); }

size_t lit_view_edges(const LitView *view)
{
  size_t count = 0;
  for (size_t i = 0; i < shot_pixels(&view->truth); i++)
    count += (size_t)edge_at(view, i, 0) + (size_t)edge_at(view, i, 1);
  return count;
}

// Is a wrong pixel within reach of an edge? Looks at the edges of a square about it.
static bool near_edge(const LitView *view, size_t pixel, double texels)
{
  const int width = (int)view->truth.width, height = (int)view->truth.height;
  Footprint footprint;
  double length = lit_view_footprint(&footprint, view, pixel) ? footprint_length(&footprint) : 0;
  int x0 = (int)pixel % width, y0 = (int)pixel / width, reach = (int)fmin(ceil(texels * length) + 1, width + height);
  for (int y = y0 - reach < 0 ? 0 : y0 - reach; y <= y0 + reach && y < height; y++)
    for (int x = x0 - reach < 0 ? 0 : x0 - reach; x <= x0 + reach && x < width; x++)
      if (view->edges[y * width + x]) return true;
  return false;
}

size_t lit_view_wrong_off_edges(const LitView *view, double texels)
{
  size_t count = 0;
  for (size_t i = 0; i < shot_pixels(&view->truth); i++)
    count += lit_view_is_wrong(view, i) && !near_edge(view, i, texels);
  return count;
}

double lit_view_bias_m(const LitView *view, Vec3 point, Vec3 normal)
{
  const ShadowView *map = map_view(view, point);
  if (!map || !map->raster.parallel) return 0;
  double depth_m = vec3_length(wide(map->axis)), cosine = fabs(vec3_dot(normal, wide(map->axis))) / depth_m;
  double growth_m = (fabs(vec3_dot(normal, wide(map->sight_x))) + fabs(vec3_dot(normal, wide(map->sight_y)))) / cosine;
  return (double)view->fit.info.slope_px * growth_m + (double)view->fit.info.depth_slack * depth_m;
}

double lit_view_texel_m(const LitView *view, Vec3 point)
{
  const ShadowView *map = map_view(view, point);
  if (!map) return 0;
  double w = map->raster.parallel ? 1 : row_dot(map->raster.w, vec3_sub(point, wide(map->raster.origin)));
  return w * vec3_length(wide(map->sight_x));
}

#include "bench/raster_views.h"

#include <math.h>

// Rows x, y, depth and w of a position before division, each in [0, 1] after it -> what OpenGL takes.
static GlView gl_view(const double rows[4][4])
{
  GlView view;
  for (int column = 0; column < 4; column++) {
    for (int row = 0; row < 3; row++)
      view.clip_from_world[4 * column + row] = (float)(2 * rows[row][column] - rows[3][column]);
    view.clip_from_world[4 * column + 3] = (float)rows[3][column];
  }
  return view;
}

static void row_set(double row[4], Vec3 v, double scale, Vec3 origin)
{
  row[0] = scale * v.x;
  row[1] = scale * v.y;
  row[2] = scale * v.z;
  row[3] = -scale * vec3_dot(v, origin);
}

// Adds `scale` times row w.
static void row_add(double rows[4][4], int row, double scale)
{
  for (int i = 0; i < 4; i++) rows[row][i] += scale * rows[3][i];
}

// A square view from `eye` along `forward`, half as wide as `tangent` at distance 1; far_m may be INFINITY.
static void map_aim(RasterView *out, GlView *gl, Vec3 eye, Vec3 forward, Vec3 right, double tangent, double near_m,
                    double far_m, uint32_t size_px)
{
  double rows[4][4], stretch = isinf(far_m) ? 1 : far_m / (far_m - near_m);
  Mat4 m;
  row_set(rows[3], forward, 1, eye);
  row_set(rows[0], right, 0.5 / tangent, eye);
  row_set(rows[1], vec3_cross(forward, right), 0.5 / tangent, eye);
  row_set(rows[2], forward, stretch, eye);
  rows[2][3] -= near_m * stretch;
  row_add(rows, 0, 0.5);
  row_add(rows, 1, 0.5);
  for (int i = 0; i < 16; i++) m.m[i] = rows[i % 4][i / 4];
  *out = raster_view_of_map(&m, eye, size_px, near_m);  // nothing before the near plane, as in OpenGL
  *gl = gl_view(rows);
}

void raster_views_aim(RasterViews *out, const Scene *scene, const CameraInfo *camera, uint32_t map_px, uint32_t cube_px)
{
  Vec3 low, high;
  scene_bounds(scene, &low, &high);
  Vec3 center = vec3_scale(vec3_add(low, high), 0.5);
  double radius = 0.5 * vec3_length(vec3_sub(high, low));

  Vec3 from = vec3_unit_or(vec3(0.35, 1, 0.25), center), light = vec3_add(center, vec3_scale(from, 2 * radius));
  Vec3 right = vec3_unit_or(vec3_cross(from, vec3(0, 0, 1)), center);
  map_aim(&out->light, &out->gl_light, light, vec3_neg(from), right, 1 / sqrt(3), radius, 3 * radius, map_px);
  out->light_position[0] = (float)light.x;
  out->light_position[1] = (float)light.y;
  out->light_position[2] = (float)light.z;

  Vec3 eye = vec3(camera->position.x, camera->position.y, camera->position.z);
  Vec3 middle = vec3_scale(vec3_add(eye, center), 0.5);
  out->cube_center[0] = (float)middle.x;
  out->cube_center[1] = (float)middle.y;
  out->cube_center[2] = (float)middle.z;
  for (int face = 0; face < 6; face++) {
    double axes[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    const double *forward = axes[face], *beside = axes[(face + 2) % 6];
    map_aim(&out->faces[face], &out->gl_faces[face], middle, vec3(forward[0], forward[1], forward[2]),
            vec3(beside[0], beside[1], beside[2]), 1, radius / 100, INFINITY, cube_px);
  }

  RasterView view = raster_view_of_camera(camera);
  const Float4 rows_px[4] = {view.x, view.y, view.depth, view.w};
  const double scale[4] = {1.0 / camera->width, 1.0 / camera->height, 1, 1};
  double rows[4][4];
  for (int row = 0; row < 4; row++)
    row_set(rows[row], vec3(rows_px[row].x, rows_px[row].y, rows_px[row].z), scale[row], eye);
  rows[2][3] -= camera->near_m;
  out->gl_camera = gl_view(rows);
}

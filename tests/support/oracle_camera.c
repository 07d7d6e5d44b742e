#include "support/oracle_camera.h"

OracleRay oracle_camera_ray(const Camera *camera, uint32_t width_px, uint32_t height_px, double x_px, double y_px)
{
  const Mat4 *world_from_camera = &camera->world_from_camera;
  bool perspective = camera->kind == CAMERA_PERSPECTIVE;
  double half_height = perspective ? tan(camera->yfov_rad / 2) : camera->ymag_m;
  double half_width = half_height * width_px / height_px;
  double right = (2 * x_px / width_px - 1) * half_width, up = (1 - 2 * y_px / height_px) * half_height;
  Vec3 origin = perspective ? vec3(0, 0, 0) : vec3(right, up, 0);
  Vec3 direction = perspective ? vec3(right, up, -1) : vec3(0, 0, -1);
  OracleRay ray = oracle_ray(mat4_point(world_from_camera, origin), mat4_direction(world_from_camera, direction),
                             camera->znear_m, camera->zfar_m);
  ray.cull = true;
  return ray;
}

static double halton(uint32_t index, uint32_t base)
{
  double value = 0, digit = 1;
  for (uint32_t rest = index; rest; rest /= base) {
    digit /= base;
    value += digit * (rest % base);
  }
  return value;
}

// Vulkan's tables, in sixteenths from the top left.
static const int sixteenths_2[][2] = {{12, 12}, {4, 4}};
static const int sixteenths_4[][2] = {{6, 2}, {14, 6}, {2, 10}, {10, 14}};
static const int sixteenths_8[][2] = {{9, 5}, {7, 11}, {13, 9}, {5, 3}, {3, 13}, {1, 7}, {11, 15}, {15, 1}};
static const int sixteenths_16[][2] = {{9, 9},  {7, 5}, {5, 10}, {12, 7}, {3, 6}, {10, 13}, {13, 11}, {11, 3},
                                       {6, 14}, {8, 1}, {4, 2},  {2, 12}, {0, 8}, {15, 4},  {14, 15}, {1, 0}};

void oracle_sample_pattern(double (*out)[2], uint32_t count)
{
  const int(*table)[2] = NULL;
  if (count == 2) table = sixteenths_2;
  if (count == 4) table = sixteenths_4;
  if (count == 8) table = sixteenths_8;
  if (count == 16) table = sixteenths_16;
  for (uint32_t i = 0; i < count; i++) {
    out[i][0] = count == 1 ? 0.5 : table ? table[i][0] / 16.0 : halton(i + 1, 2);
    out[i][1] = count == 1 ? 0.5 : table ? table[i][1] / 16.0 : halton(i + 1, 3);
  }
}

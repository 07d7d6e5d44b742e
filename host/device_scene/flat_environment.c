#include <math.h>
#include <string.h>

#include "device_scene/flat_scene.h"

static Float3 scaled(const float color[3], float factor)
{
  return (Float3){color[0] * factor, color[1] * factor, color[2] * factor};
}

// Adds radiance from a unit direction over a solid angle to the nine harmonics.
static void harmonics_add(double sums[9][3], Vec3 d, double solid_angle_sr, const double radiance[3])
{
  const double basis[9] = {
      0.282095,
      0.488603 * d.y,
      0.488603 * d.z,
      0.488603 * d.x,
      1.092548 * d.x * d.y,
      1.092548 * d.y * d.z,
      0.315392 * (3 * d.z * d.z - 1),
      1.092548 * d.x * d.z,
      0.546274 * (d.x * d.x - d.y * d.y),
  };
  for (int i = 0; i < 9; i++)
    for (int c = 0; c < 3; c++) sums[i][c] += basis[i] * radiance[c] * solid_angle_sr;
}

static void gradient_radiance(double out[3], const EnvironmentInfo *info, double y)
{
  Float3 pole = y >= 0 ? info->zenith : info->ground;
  double f = fabs(y);
  out[0] = info->horizon.x + f * (pole.x - info->horizon.x);
  out[1] = info->horizon.y + f * (pole.y - info->horizon.y);
  out[2] = info->horizon.z + f * (pole.z - info->horizon.z);
}

void flat_environment_make(FlatScene *flat, const Environment *from)
{
  EnvironmentInfo *info = &flat->environment;
  const bool is_image = from->kind == ENVIRONMENT_IMAGE, is_gradient = from->kind == ENVIRONMENT_GRADIENT;
  *info = (EnvironmentInfo){
      .kind = is_image      ? ENVIRONMENT_KIND_IMAGE
              : is_gradient ? ENVIRONMENT_KIND_GRADIENT
                            : ENVIRONMENT_KIND_CONSTANT,
      .width = is_image ? from->image.width : 128,
      .height = is_image ? from->image.height : 64,
      .cos_rotation = (float)cos(from->rotation_rad),
      .sin_rotation = (float)sin(from->rotation_rad),
      .intensity = from->intensity,
      .zenith = scaled(is_gradient ? from->zenith : from->constant, from->intensity),
      .horizon = scaled(is_gradient ? from->horizon : from->constant, from->intensity),
      .ground = scaled(is_gradient ? from->ground : from->constant, from->intensity),
  };
  double sums[9][3] = {{0}}, brightest = 0;
  for (uint32_t row = 0; row < info->height; row++) {
    double top = M_PI * row / info->height, bottom = M_PI * (row + 1) / info->height;
    double theta = 0.5 * (top + bottom), solid_angle_sr = 2 * M_PI / info->width * (cos(top) - cos(bottom));
    for (uint32_t column = 0; column < info->width; column++) {
      double phi = 2 * M_PI * ((column + 0.5) / info->width - 0.5) - from->rotation_rad;
      Vec3 direction = vec3(cos(phi) * sin(theta), cos(theta), sin(phi) * sin(theta));
      double radiance[3];
      if (is_image) {
        const float *pixel = from->image.pixels + 4 * ((size_t)row * info->width + column);
        for (int c = 0; c < 3; c++) radiance[c] = pixel[c] * from->intensity;
      } else {
        gradient_radiance(radiance, info, direction.y);
      }
      brightest = fmax(brightest, fmax(radiance[0], fmax(radiance[1], radiance[2])));
      harmonics_add(sums, direction, solid_angle_sr, radiance);
    }
  }
  for (int i = 0; i < 9; i++) info->harmonics[i] = (Float3){(float)sums[i][0], (float)sums[i][1], (float)sums[i][2]};
  flat->environment_lights = brightest > 0;
}

#include "plan/cube_error.h"

#include "base/math3d.h"

double cube_parallax_rad(const CubeSight *sight)
{
  double o = sight->offset_m, d = sight->distance_m;
  if (o == 0 || isinf(d)) return 0;
  double sine = o / d * fabs(sin(sight->angle_rad));
  if (!(sine <= 1)) return M_PI;
  return d < o ? M_PI - asin(sine) : asin(sine);
}

double cube_parallax_most_rad(double offset_m, double distance_m)
{
  return cube_parallax_rad(&(CubeSight){offset_m, distance_m, M_PI / 2});
}

double cube_near_radius_m(double offset_m, double most_rad) { return offset_m / sin(fmin(most_rad, M_PI / 2)); }

double cube_texel_rad(uint32_t size_px) { return 2 * atan(1.0 / (size_px - 1.0)); }

double reflected_change_rad(const ReflectorView *view)
{
  return view->pixel_rad * (1 + 2 * view->distance_m / (view->radius_m * cos(view->slant_rad)));
}

double cube_wrong_px(const ReflectorView *view, double error_rad)
{
  return fmin(view->edge_px * error_rad / reflected_change_rad(view), view->area_px);
}

#include "render/reflector_cube.h"

#include <math.h>

#include "render/reflector_shape.h"

// Where a rough reflector's cube is: what is flat, of its reach, or large, of the scene's diagonal, has it before what
// is seen of it, and how far.
#define ROUGH_FLAT 0.1
#define ROUGH_LARGE 0.25
#define ROUGH_CENTER_OFF 0.15

static Float3 narrow(Vec3 v) { return (Float3){(float)v.x, (float)v.y, (float)v.z}; }

uint32_t cube_size_choose(const CubeOptions *options, double pixels)
{
  if (options->size_px) return options->size_px;
  double width = 2 * sqrt(pixels / M_PI);
  uint32_t size = CUBE_LEAST_PX;
  while (size < CUBE_MOST_PX && size < width) size *= 2;
  return size;
}

// A lobe is 2.6 alpha wide where it is half as strong; four texels of a face are alpha wide.
uint32_t rough_cube_size_choose(const CubeOptions *options, const Reflector *reflector, uint32_t factor)
{
  uint32_t most = cube_size_choose(options, (double)reflector->rough_pixels * factor * factor), size = CUBE_LEAST_PX;
  double wanted = 4 / pow((double)reflector->least_roughness, 2);
  if (options->size_px) return most;
  while (size < most && size < wanted) size *= 2;
  return size;
}

// From where a rough surface is reflected in all it shows: what stands on the middle of a floor would hide the room
// from there, and so would most things about the middle of something large. Nothing lies between the camera and what it
// sees, from which the centre is as far as a share of the reflector's reach, at most half of the way.
static Vec3 rough_center(const RoughSight *sight, double reach_m)
{
  const double way = vec3_length(sight->way_m), back = fmin(ROUGH_CENTER_OFF * reach_m, 0.5 * way);
  return vec3_sub(sight->place_m, vec3_scale(sight->way_m, way > 0 ? back / way : 0));
}

CubeInfo cube_fit(const DeviceScene *scene, uint32_t object, uint32_t size, const RoughSight *sight)
{
  Vec3 low, high;
  if (!scene_object_bounds(scene->source, object, &low, &high)) low = high = vec3(0, 0, 0);
  Vec3 center = vec3_scale(vec3_add(low, high), 0.5);
  double margin = 1e-5 * scene->extent_m;  // rounding of rays that start on the box
  Vec3 half = vec3_scale(vec3_sub(high, low), 0.5);
  double reach = fmax(fmax(half.x, half.y), fmax(half.z, margin));
  const double least = fmin(half.x, fmin(half.y, half.z));
  const bool flat = least < ROUGH_FLAT * reach;
  const bool large = reach > ROUGH_LARGE * scene->extent_m;
  if (sight && (flat || large)) center = rough_center(sight, reach);
  const Vec3 wider = vec3(margin, margin, margin);
  return (CubeInfo){.center = narrow(center),
                    .low = narrow(vec3_sub(vec3_sub(scene->low, wider), center)),
                    .high = narrow(vec3_sub(vec3_add(scene->high, wider), center)),
                    .reach_m = (float)reach,
                    .size = size,
                    .object = object,
                    .first_level = CUBE_NONE,
                    .hull_least = object_is_convex(scene->source, object) ? INFINITY : (float)(0.999 / reach)};
}

CubeInfo reflector_cube(const Frame *frame, uint32_t object, double pixels)
{
  return cube_fit(frame->scene, object, cube_size_choose(&frame->request.plan.cubes, pixels), NULL);
}

CubeInfo reflector_rough_cube(const Frame *frame, const Reflector *reflector, uint32_t factor)
{
  return cube_fit(frame->scene, reflector->object,
                  rough_cube_size_choose(&frame->request.plan.cubes, reflector, factor), &reflector->sight);
}

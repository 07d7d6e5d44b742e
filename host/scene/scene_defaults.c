#include "scene/scene_defaults.h"

#include <ctype.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/nearest.h"

#define FIT_YFOV_RAD (M_PI / 4)
#define FIT_INSIDE 0.95  // of half the picture

// Distance from the centre at which a camera that looks along -axes[2] sees all corners, and their extreme depths.
static double fit_distance(double *nearest_m, double *farthest_m, const Vec3 axes[3], Vec3 half, double aspect)
{
  double tan_y = FIT_INSIDE * tan(FIT_YFOV_RAD / 2), tan_x = tan_y * aspect;
  double distance = 0, least = INFINITY, most = -INFINITY;
  for (int i = 0; i < 8; i++) {
    Vec3 corner = vec3_mul(half, vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    double x = fabs(vec3_dot(corner, axes[0])), y = fabs(vec3_dot(corner, axes[1])), z = vec3_dot(corner, axes[2]);
    distance = fmax(distance, z + fmax(x / tan_x, y / tan_y));
    least = fmin(least, -z);
    most = fmax(most, -z);
  }
  *nearest_m = distance + least;
  *farthest_m = distance + most;
  return distance;
}

void scene_camera_fit(Camera *out, Vec3 low, Vec3 high, double aspect)
{
  Vec3 center = vec3_scale(vec3_add(low, high), 0.5), half = vec3_scale(vec3_sub(high, low), 0.5);
  // A scene without extent is looked at from a distance at which its float coordinates still differ.
  double least = fmax(1e-5 * vec3_length(center), 1e-30);
  if (vec3_length(half) < least) half = vec3(least, least, least);
  Vec3 back = vec3_unit_or(vec3(0.5, 0.35, 1), vec3(0, 0, 1));
  Vec3 right = vec3_unit_or(vec3_cross(vec3(0, 1, 0), back), vec3(1, 0, 0)), up = vec3_cross(back, right);
  const Vec3 axes[3] = {right, up, back};
  double nearest_m = 0, farthest_m = 0, distance = fit_distance(&nearest_m, &farthest_m, axes, half, aspect);
  Vec3 eye = vec3_add(center, vec3_scale(back, distance));
  *out = (Camera){
      .kind = CAMERA_PERSPECTIVE,
      .yfov_rad = FIT_YFOV_RAD,
      .znear_m = nearest_m / 100,
      .zfar_m = farthest_m * 100,
      .world_from_camera = {{right.x, right.y, right.z, 0, up.x, up.y, up.z, 0, back.x, back.y, back.z, 0, eye.x, eye.y,
                             eye.z, 1}},
  };
}

static Status fail_unknown(const Scene *scene, const char *choice, Log *log)
{
  const char **names = calloc(scene->camera_count + 2ull, sizeof *names);
  if (!names) return log_no_memory(log, scene->path);
  for (uint32_t i = 0; i < scene->camera_count; i++) names[i] = scene->cameras[i].name;
  names[scene->camera_count] = "fit";
  Status status = log_fail(log, STATUS_USAGE, "%s: no camera '%.64s': did you mean '%.64s'?", scene->path, choice,
                           nearest_name(choice, names));
  free(names);
  return status;
}

Status scene_camera_choose(Camera *out, const Scene *scene, const char *choice, double aspect, Log *log)
{
  uint32_t chosen = 0;
  if (choice && name_is_index(choice)) {
    unsigned long index = strtoul(choice, NULL, 10);
    if (index >= scene->camera_count)
      return log_fail(log, STATUS_USAGE, "%s: no camera %.20s: the scene has %u, numbered from 0", scene->path, choice,
                      scene->camera_count);
    chosen = (uint32_t)index;
  } else if (choice && strcmp(choice, "fit") != 0) {
    while (chosen < scene->camera_count && strcmp(scene->cameras[chosen].name, choice) != 0) chosen++;
    if (chosen == scene->camera_count) return fail_unknown(scene, choice, log);
  } else if (choice || scene->camera_count == 0) {
    Vec3 low = vec3(-1, -1, -1), high = vec3(1, 1, 1);
    scene_bounds(scene, &low, &high);
    scene_camera_fit(out, low, high, aspect);
    return STATUS_OK;
  }
  *out = scene->cameras[chosen];
  return STATUS_OK;
}

void scene_set_sky(Scene *scene)
{
  scene->environment = (Environment){
      .kind = ENVIRONMENT_GRADIENT,
      .zenith = {0.22f, 0.30f, 0.42f},
      .horizon = {0.36f, 0.38f, 0.40f},
      .ground = {0.12f, 0.11f, 0.10f},
      .intensity = 1,
  };
}

static Status sun_add(Scene *scene, Log *log)
{
  Light *lights = realloc(scene->lights, (scene->light_count + 1ull) * sizeof *lights);
  if (!lights) return log_no_memory(log, scene->path);
  scene->lights = lights;
  char *name = strdup("built-in sun");
  if (!name) return log_no_memory(log, scene->path);
  scene->lights[scene->light_count++] = (Light){
      .name = name,
      .kind = LIGHT_DIRECTIONAL,
      .color = {1, 0.96f, 0.90f},
      .intensity = 2,
      .range_m = INFINITY,
      .direction_world = vec3_unit_or(vec3(0.5, -1, -0.6), vec3(0, -1, 0)),
  };
  return STATUS_OK;
}

Status scene_add_default_lighting(Scene *scene, bool key_light, Log *log)
{
  Status status = STATUS_OK;
  if (scene->light_count > 0) {
    scene->environment = (Environment){.kind = ENVIRONMENT_CONSTANT, .intensity = 1};
    return STATUS_OK;
  }
  if (key_light) TRY(sun_add(scene, log));
  scene_set_sky(scene);
  log_info(log, "%s: has no lights: lit by the built-in sky%s", scene->path, key_light ? " and sun" : "");

done:
  return status;
}

// Rows about what is near a reflector, and about mirrors that face each other.

#include <math.h>

#include "stability/mirror_view.h"
#include "stability/reflection_measures.h"

static int glow_add(Scene *scene, double red, double green, double blue)
{
  return scene_add_material(scene, material_glowing(vec3(red, green, blue)));
}

// The worst of several methods: no pixel that shows one thing may show another.
static Status nothing_wrong(StabilityPoint *point, Lab *lab, const Scene *scene, const Camera *camera,
                            const ReflectionMethod *methods, int count, float near_radius_m)
{
  Status status = STATUS_OK;
  point->measured = point->bound = point->warned = 0;
  for (int i = 0; i < count; i++) {
    double share;
    TRY(mirror_view_wrong(&share, lab, scene, camera, methods[i], near_radius_m));
    if (!(share <= point->measured)) point->measured = share;
  }

done:
  return status;
}

static const ReflectionMethod lists[] = {REFLECTIONS_SNAPSHOT, REFLECTIONS_CANDIDATES, REFLECTIONS_MIXED};

Status measure_radius_crossing(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const double radius = 0.5, from = 0.8;
  Scene scene = scene_empty();
  scene_add_sphere(&scene, mirror_view_material(&scene, 0.9), vec3(0, 0, 0), radius, 32);
  mirror_view_walls(&scene);
  scene_add_box(&scene, glow_add(&scene, 0.9, 0.9, 0.9), vec3(from, -0.3, -0.2), vec3(from + 1, 0.3, 0.4));
  scene_add_sphere(&scene, glow_add(&scene, 0.9, 0.5, 0.1), vec3(0, 0.2, from + 0.4), 0.4, 24);
  Camera camera = camera_perspective(vec3(2.4, 0.9, 2.8), vec3(0, 0, 0), 0.35);
  Status status = nothing_wrong(point, lab, &scene, &camera, lists, 3, (float)(from + point->value));
  scene_free(&scene);
  return status;
}

// A flat mirror in the wall of a room, seen from its right.
static Scene mirror_wall_scene(void)
{
  Scene scene = scene_empty();
  scene_add_quad(&scene, mirror_view_material(&scene, 0.9), vec3(-1.5, -1, -1), vec3(3, 0, 0), vec3(0, 2, 0));
  mirror_view_walls(&scene);
  return scene;
}

static Camera mirror_wall_camera(void) { return camera_perspective(vec3(1.9, 0.4, 0.8), vec3(0.4, 0, -1), 0.8); }

Status measure_snapshot_disocclusion(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const ReflectionMethod snapshot = REFLECTIONS_SNAPSHOT;
  const double angle = point->value * M_PI / 180, c = cos(angle), s = sin(angle);
  const Vec3 u = {0.8 * c, 0, -0.8 * s}, v = {0, 0.8, 0}, n = {0.02 * s, 0, 0.02 * c};
  Vec3 corner = vec3_sub(vec3(0.3, -0.4, 0), vec3_scale(u, 0.5));
  Scene scene = mirror_wall_scene();
  scene_add_quad(&scene, glow_add(&scene, 0.9, 0.5, 0.1), vec3_add(corner, n), u, v);
  scene_add_quad(&scene, glow_add(&scene, 0.1, 0.5, 0.9), corner, v, u);
  scene_join_last(&scene);
  Camera camera = mirror_wall_camera();
  Status status = nothing_wrong(point, lab, &scene, &camera, &snapshot, 1, 1.2f);
  scene_free(&scene);
  return status;
}

Status measure_reflection_occluder(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Scene scene = mirror_wall_scene();
  scene_add_sphere(&scene, glow_add(&scene, 0.9, 0.5, 0.1), vec3(-0.1, 0, -0.3), 0.4, 32);
  Vec3 at = vec3(0.6, -0.3, -1 + point->value);
  scene_add_quad(&scene, glow_add(&scene, 0.1, 0.5, 0.9), at, vec3(0, 0.6, 0), vec3(0, 0, 0.25));
  scene.materials[scene.material_count - 1].double_sided = true;
  Camera camera = camera_perspective(vec3(2.8, 0.4, 0.4), vec3(0.8, 0, -1), 0.7);
  Status status = nothing_wrong(point, lab, &scene, &camera, lists, 3, 0.5f);
  scene_free(&scene);
  return status;
}

Status measure_snapshot_overflow(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  static const ReflectionMethod snapshot = REFLECTIONS_SNAPSHOT;
  const double half = 0.5 * tan(0.5 * point->value * M_PI / 180);
  Scene scene = mirror_wall_scene();
  scene_add_box(&scene, glow_add(&scene, 0.9, 0.5, 0.1), vec3(-half, -0.2, -0.5), vec3(half, 0.2, -0.4));
  Camera camera = camera_perspective(vec3(0.3, 1.3, 0.6), vec3(0, 0, -1), 0.9);
  Status status = nothing_wrong(point, lab, &scene, &camera, &snapshot, 1, 0.8f);
  scene_free(&scene);
  return status;
}

// Two mirrors that glow: each sends 1, and rho of what it gets; between them that is 1 / (1 - rho).
Status measure_facing_mirrors(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  enum { SIDE = 16, BOUNCES_MOST = 1000 };
  static const double invisible = 1.0 / 255;
  Status status = STATUS_OK;
  const double rho = point->value, all = 1 / (1 - rho);
  point->measured = 0;
  for (int i = 0; i < 2; i++) {
    Shot shot = {0};
    Scene scene = scene_empty();
    Material mirror = material_plain(vec3(rho, rho, rho), 1, 0);
    for (int channel = 0; channel < 3; channel++) mirror.emission[channel] = 1;
    int material = scene_add_material(&scene, mirror);
    scene_add_quad(&scene, material, vec3(-4, -4, -1), vec3(8, 0, 0), vec3(0, 8, 0));
    scene_add_quad(&scene, material, vec3(-4, -4, 1), vec3(0, 8, 0), vec3(8, 0, 0));
    RenderSettings settings = lab_settings(SIDE, SIDE);
    settings.max_depth = BOUNCES_MOST;
    settings.reflections = i ? REFLECTIONS_MIXED : REFLECTIONS_RAYS;
    Camera camera = camera_perspective(vec3(0, 0, 0.5), vec3(0, 0, -1), 1e-3);
    status = lab_render_scene(&shot, lab, &scene, &camera, &settings);
    for (size_t k = 0; !status && k < shot_pixels(&shot); k++) {
      double left = fabs(all - (double)shot.radiance[4 * k]);
      if (!(left <= point->measured)) point->measured = left;
    }
    shot_free(&shot);
    scene_free(&scene);
    if (status) return status;
  }
  point->bound = point->warned = invisible * all;
  return status;
}

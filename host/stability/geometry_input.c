#include <stdlib.h>
#include <string.h>

#include "device_scene/flat_scene.h"
#include "shared/aov.h"
#include "stability/geometry_measures.h"

enum Poison {
  POISON_NONE,
  POISON_VERTEX_NAN,
  POISON_VERTEX_INFINITE,
  POISON_VERTEX_HUGE,
  POISON_NORMAL_NAN,
  POISON_NORMAL_ZERO,
  POISON_LIGHT_HUGE,
  POISON_LIGHT_ON_SURFACE,
};

static Primitive *primitive_of(Scene *scene, uint32_t object)
{
  return scene->meshes[scene->objects[object].mesh].primitives;
}

// Applies to the second object and the second light.
static void poison_apply(Scene *scene, enum Poison poison)
{
  Primitive *primitive = primitive_of(scene, 1);
  float *position = primitive->positions[primitive->vertex_count / 2];
  float(*normals)[3] = primitive->normals;
  Light *light = &scene->lights[1];
  switch (poison) {
    case POISON_NONE: break;
    case POISON_VERTEX_NAN: position[1] = NAN; break;
    case POISON_VERTEX_INFINITE: position[1] = INFINITY; break;
    case POISON_VERTEX_HUGE: position[1] = 1e38f; break;
    case POISON_NORMAL_NAN: normals[primitive->vertex_count / 2][0] = NAN; break;
    case POISON_NORMAL_ZERO: memset(normals[primitive->vertex_count / 2], 0, sizeof *normals); break;
    case POISON_LIGHT_HUGE: light->intensity = 3e38f; break;
    case POISON_LIGHT_ON_SURFACE: light->position_world = vec3(0, 0, 0); break;
  }
}

// Two balls over a floor, the second so that no ray of light or sight passes by it to another surface but the floor's
// rim.
static Scene poison_scene(void)
{
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(0.7, 0.7, 0.7), 0, 1));
  scene_add_sphere(&scene, white, vec3(-1, 0.7, 0), 0.6, 12);
  scene_add_sphere(&scene, white, vec3(1, 0.7, 0), 0.6, 12);
  scene_add_quad(&scene, white, vec3(-3, 0, 3), vec3(6, 0, 0), vec3(0, 0, -6));
  scene_add_light(&scene, light_directional(vec3(0.3, -1, -0.4), 2));
  scene_add_light(&scene, light_point(vec3(0, 3, 2), 10));
  return scene;
}

// Pixels outside the second object and its shadow that a poisoned vertex or normal changes; values that are no number
// anywhere. What is refused touches none. A light changes the picture: there only what is no number counts.
Status measure_poison(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  Shot clean = {0}, bare = {0}, poisoned = {0};
  uint32_t size = lab->quick ? 64 : 160;
  enum Poison poison = (enum Poison)point->value;
  bool of_light = poison >= POISON_LIGHT_HUGE;
  Scene scene = poison_scene(), without = poison_scene();
  Camera camera = camera_perspective(vec3(0, 3, 6), vec3(0, 0.3, 0), 0.6);
  RenderSettings settings = lab_settings(size, size);
  Log refusal = {0}, *log = lab->log;
  TRY(scene_check_complete(&scene, log));
  TRY(scene_check_complete(&without, log));
  TRY(lab_render_scene(&clean, lab, &scene, &camera, &settings));
  without.objects[1].world_from_object = mat4_from_trs(vec3(0, 0, 0), (const double[4]){0, 0, 0, 1}, vec3(0, 0, 0));
  TRY(lab_render_scene(&bare, lab, &without, &camera, &settings));
  poison_apply(&scene, poison);
  lab->log = &refusal;
  Status refused = lab_render_scene(&poisoned, lab, &scene, &camera, &settings);
  lab->log = log;
  if (refused && refused != STATUS_BAD_SCENE) status = log_fail(log, refused, "%s", refusal.error);
  size_t touched = 0;
  for (size_t i = 0; i < shot_pixels(&poisoned); i++) {
    const float *now = poisoned.radiance + 4 * i, *before = clean.radiance + 4 * i, *empty = bare.radiance + 4 * i;
    bool of_object = lab_differ((double)before[0], (double)empty[0]) || clean.ids[i] == 1;
    touched += !isfinite(now[0]) || (!of_light && !of_object && lab_differ((double)now[0], (double)before[0]));
  }
  if (poisoned.radiance) TRY(lab_keep(lab, poisoned.radiance, clean.radiance, size, size, 4));
  point->measured = (double)touched / (double)shot_pixels(&clean);

done:
  lab->log = log;
  shot_free(&clean);
  shot_free(&bare);
  shot_free(&poisoned);
  scene_free(&scene);
  scene_free(&without);
  return status;
}

// Mirrors positions and normals in place, and turns triangles round where the determinant is negative.
static void primitive_bake(Primitive *primitive, const double signs[3])
{
  bool turned = signs[0] * signs[1] * signs[2] < 0;
  for (uint32_t i = 0; i < primitive->vertex_count; i++)
    for (int axis = 0; axis < 3; axis++) {
      primitive->positions[i][axis] *= (float)signs[axis];
      primitive->normals[i][axis] *= (float)signs[axis];
    }
  for (uint32_t i = 0; i < primitive->triangle_count && turned; i++) {
    uint32_t second = primitive->triangles[i][1];
    primitive->triangles[i][1] = primitive->triangles[i][2];
    primitive->triangles[i][2] = second;
  }
}

// A ball and a box beside the origin, mirrored along the axes whose bits the point's value has: by their transform, and
// baked.
Status measure_mirrored(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  Shot shots[2] = {0};
  uint32_t size = lab->quick ? 64 : 160, bits = (uint32_t)point->value;
  const double signs[3] = {bits & 1 ? -1 : 1, bits & 2 ? -1 : 1, bits & 4 ? -1 : 1};
  const double still[4] = {0, 0, 0, 1};
  for (int baked = 0; baked < 2; baked++) {
    Scene scene = scene_empty();
    int white = scene_add_material(&scene, material_plain(vec3(0.7, 0.7, 0.7), 0, 1));
    scene_add_sphere(&scene, white, vec3(0.7, 0.3, 0.2), 0.6, 10);
    scene_add_box(&scene, white, vec3(-1.1, -0.6, 0.1), vec3(-0.2, 0.3, 0.6));
    scene_add_light(&scene, light_point(vec3(1, 3, 4), 12));
    TRY(scene_check_complete(&scene, lab->log));
    for (uint32_t i = 0; i < scene.object_count; i++)
      if (baked)
        primitive_bake(primitive_of(&scene, i), signs);
      else
        scene.objects[i].world_from_object = mat4_from_trs(vec3(0, 0, 0), still, vec3(signs[0], signs[1], signs[2]));
    Camera camera = camera_perspective(vec3(0.5, 1, 6), vec3(0, 0, 0), 0.6);
    RenderSettings settings = lab_settings(size, size);
    status = lab_render_scene(&shots[baked], lab, &scene, &camera, &settings);
    scene_free(&scene);
    TRY(status);
  }
  TRY(lab_keep(lab, shots[0].radiance, shots[1].radiance, size, size, 4));
  for (size_t i = 0; i < 4 * shot_pixels(&shots[0]); i++) {
    double a = shots[0].radiance[i], b = shots[1].radiance[i];
    if (i % 4 < 3) point->measured = fmax(point->measured, fabs(a - b) / fmax(fabs(b), 1e-3));
  }
  point->bound = point->warned = 0x1p-22;

done:
  shot_free(&shots[0]);
  shot_free(&shots[1]);
  return status;
}

// A unit ball scaled by (1, s, 1 / s): a vertex at unit n has the normal (n.x, n.y / s, n.z s), made unit.
Status measure_stretched(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  Status status = STATUS_OK;
  FlatScene flat = {0};
  const double still[4] = {0, 0, 0, 1}, s = point->value;
  Scene scene = scene_empty();
  scene_add_sphere(&scene, scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1)), vec3(0, 0, 0), 1, 24);
  TRY(scene_check_complete(&scene, lab->log));
  scene.objects[0].world_from_object = mat4_from_trs(vec3(0, 0, 0), still, vec3(1, s, 1 / s));
  TRY(flat_scene_make(&flat, &scene, lab->log));
  for (uint32_t i = 0; i < flat.vertex_count; i++) {
    Vec3 n = vec3_from_floats(primitive_of(&scene, 0)->normals[i]), up = vec3(0, 1, 0);
    Vec3 right = vec3_unit_or(vec3(n.x, n.y / s, n.z * s), up), got = vec3_from_floats(flat.normals[i]);
    point->measured = fmax(point->measured, vec3_length(vec3_cross(right, got)));
    if (!(vec3_dot(right, got) > 0)) point->measured = M_PI;
  }
  point->bound = point->warned = 1e-5;

done:
  flat_scene_free(&flat);
  scene_free(&scene);
  return status;
}

// An object that swings towards the camera and back once a second, at 60 frames a second for two: how often the plan
// takes another method. The sweep is the picture's height.
Status measure_planner_flicker(StabilityPoint *point, Lab *lab, ShadowMethod method)
{
  enum { FRAMES = 120 };
  Status status = STATUS_OK;
  uint32_t height = (uint32_t)point->value;
  PrimaryMethod before = PRIMARY_AUTO;
  for (int frame = 0; frame < FRAMES; frame++) {
    FlatScene flat = {0};
    Scene scene = scene_empty();
    int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
    scene_add_sphere(&scene, white, vec3(0, 0, -5 + 4 * sin(2 * M_PI * frame / 60)), 1, 24);
    status = scene_check_complete(&scene, lab->log);
    if (!status) status = flat_scene_make(&flat, &scene, lab->log);
    SceneFacts facts = {.triangle_count = flat.triangle_count,
                        .pixel_count = (uint64_t)height * height * 16 / 9,
                        .gpu = device_info(lab->device)->is_gpu,
                        .least_roughness = flat.least_roughness};
    RenderSettings settings = lab_settings(height * 16 / 9, height);
    settings.primary = PRIMARY_AUTO;
    PrimaryMethod now = plan_make(&settings, &facts).primary;
    point->measured += frame > 0 && now != before ? 0.5 : 0;
    before = now;
    flat_scene_free(&flat);
    scene_free(&scene);
    if (status) break;
  }
  // A change there and back a swing.
  point->bound = point->warned = 2;
  return status;
}

// Lights that lie in the planes of walls, on them, or a few roundings off: what they lie on does not shadow them, and
// hybrid shadows are those of rays.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/effort.h"
#include "support/gltf_build.h"
#include "support/picture_fixture.h"
#include "support/test_device.h"

static const uint32_t width = 160, height = 100;

static double random_next(uint32_t *state)
{
  *state = *state * 1664525u + 1013904223u;
  return (*state >> 8) / 16777216.0;
}

// A floor, two walls, boxes large and small, and balls. `closed`: the walls too are boxes.
static Scene scene_make(bool closed)
{
  Scene scene = scene_empty();
  int grey = scene_add_material(&scene, material_plain(vec3(0.7, 0.7, 0.7), 0, 1));
  if (closed) {
    scene_add_box(&scene, grey, vec3(-6, -0.5, -6), vec3(6, 0, 6));
    scene_add_box(&scene, grey, vec3(-6, 0, -6.1), vec3(6, 5.3, -6));
    scene_add_box(&scene, grey, vec3(-6.1, 0, -6), vec3(-6, 5.3, 6));
  } else {
    scene_add_quad(&scene, grey, vec3(-6, 0, 6), vec3(12, 0, 0), vec3(0, 0, -12));
    scene_add_quad(&scene, grey, vec3(-6, 0, -6), vec3(12, 0, 0), vec3(0, 5.3, 0));
    scene_add_quad(&scene, grey, vec3(-6, 0, 6), vec3(0, 0, -12), vec3(0, 5.3, 0));
  }
  for (int i = 0; i < 5; i++) {
    scene_add_box(&scene, grey, vec3(-4 + 2 * i, 0, -2), vec3(-3.2 + 2 * i, 0.6 + 0.3 * i, -1.4));
    scene_add_box(&scene, grey, vec3(-4 + 2 * i, 0, 1), vec3(-3.2 + 2 * i, 1.1, 1.7));
    scene_add_sphere(&scene, grey, vec3(-4 + 2 * i, 0.5 + 0.1 * i, 3), 0.5, 6 + 4 * i);
    scene_add_box(&scene, grey, vec3(-4 + 2 * i, 2, 0), vec3(-3.98 + 2 * i, 2.02, 0.02));
  }
  return scene;
}

// Turns and moves all objects: their planes are then those of no coordinate.
static Mat4 scene_turn(Scene *scene)
{
  const double turn[4] = {0.18, 0.31, -0.12, sqrt(1 - 0.18 * 0.18 - 0.31 * 0.31 - 0.12 * 0.12)};
  Mat4 turned = mat4_from_trs(vec3(0.3, -0.7, 1.1), turn, vec3(1, 1, 1));
  for (uint32_t i = 0; i < scene->object_count; i++)
    scene->objects[i].world_from_object = mat4_mul(turned, scene->objects[i].world_from_object);
  return turned;
}

// In the plane of a triangle of the scene, at times within it, at times as far off as rounding may move it.
static Vec3 place_choose(const Scene *scene, uint32_t *state)
{
  const Object *object = &scene->objects[(uint32_t)(random_next(state) * scene->object_count)];
  const Primitive *primitive = &scene->meshes[object->mesh].primitives[0];
  const uint32_t *triangle = primitive->triangles[(uint32_t)(random_next(state) * primitive->triangle_count)];
  Vec3 corners[3];
  for (int k = 0; k < 3; k++)
    corners[k] = mat4_point(&object->world_from_object, vec3_from_floats(primitive->positions[triangle[k]]));
  double reach = random_next(state) < 0.5 ? 1 : 4;
  double u = reach * random_next(state) / 2, v = reach * random_next(state) / 2;
  Vec3 a = vec3_sub(corners[1], corners[0]), b = vec3_sub(corners[2], corners[0]);
  Vec3 point = vec3_add(corners[0], vec3_add(vec3_scale(a, u), vec3_scale(b, v)));
  double off = random_next(state) < 0.5 ? 0 : ldexp(random_next(state) - 0.5, -13 - (int)(10 * random_next(state)));
  return vec3_add(point, vec3_scale(vec3_unit_or(vec3_cross(a, b), vec3(0, 1, 0)), off));
}

static Picture render(const Scene *scene, const Camera *camera, ShadowMethod method, uint32_t lanes)
{
  PictureRequest request = picture_request(width, height, 1);
  request.lanes = lanes;
  request.settings.shadows = method;
  return picture_render(scene, camera, &request);
}

// Pixels that hybrid shadows and rays see apart; the lights are said.
static uint32_t pixels_apart(const Scene *scene, const Camera *camera, uint32_t lanes)
{
  uint32_t apart = 0;
  Picture a = render(scene, camera, SHADOWS_RAYS, lanes), b = render(scene, camera, SHADOWS_HYBRID, lanes);
  for (uint32_t i = 0; i < width * height; i++)
    apart += memcmp(a.radiance[i], b.radiance[i], sizeof a.radiance[i]) != 0;
  for (uint32_t i = 0; apart && i < scene->light_count; i++) {
    const Vec3 at = scene->lights[i].position_world;
    printf("light at %.9g %.9g %.9g: %u pixels apart\n", at.x, at.y, at.z, apart);
  }
  picture_free(&a);
  picture_free(&b);
  return apart;
}

static void lights_in_walls_are_judged_alike(void **state)
{
  static const uint32_t lanes[] = {16, 8, 1};
  uint32_t seed = 3, apart = 0, rounds = effort_is_full() ? 400 : 24;
  for (uint32_t round = 0; round < rounds; round++) {
    Scene scene = scene_make(round & 1);
    Camera camera = camera_perspective(vec3(1, 5, 9), vec3(0, 0.4, 0), 0.8);
    if (round & 2) {
      Mat4 turned = scene_turn(&scene);
      camera.world_from_camera = mat4_mul(turned, camera.world_from_camera);
    }
    Vec3 at = place_choose(&scene, &seed), towards = place_choose(&scene, &seed);
    scene_add_light(&scene, round & 4 ? light_spot(at, towards, 100, 0.5, 0.9) : light_point(at, 60));
    apart += pixels_apart(&scene, &camera, test_on_gpu() ? 0 : lanes[round % 3]);
    scene_free(&scene);
  }
  assert_int_equal(apart, 0);
}

// A room with a lamp on its ceiling, in it or a rounding above it: no pixel of it is dark.
static void what_a_light_lies_on_does_not_shadow_it(void **state)
{
  for (int off = -1; off <= 1; off++) {
    Scene scene = scene_empty();
    int grey = scene_add_material(&scene, material_plain(vec3(0.7, 0.7, 0.7), 0, 1));
    scene_add_quad(&scene, grey, vec3(-3.3, 0, 3.3), vec3(6.6, 0, 0), vec3(0, 0, -6.6));
    scene_add_quad(&scene, grey, vec3(-3.3, 2.7, -3.3), vec3(6.6, 0, 0), vec3(0, 0, 6.6));
    Mat4 turned = scene_turn(&scene);
    Vec3 lamp = mat4_point(&turned, vec3(0.4, 2.7 * (1 + off * 6e-8), -0.2));
    scene_add_light(&scene, light_point(lamp, 60));
    Camera camera = camera_perspective(vec3(1, 2.2, 2.8), vec3(0, 0, 0), 0.8);
    camera.world_from_camera = mat4_mul(turned, camera.world_from_camera);
    Picture a = render(&scene, &camera, SHADOWS_RAYS, 0), b = render(&scene, &camera, SHADOWS_NONE, 0);
    uint32_t dark = 0, lit = 0;
    for (uint32_t i = 0; i < width * height; i++) {
      lit += b.radiance[i][0] > 0;
      dark += b.radiance[i][0] > 0 && !(a.radiance[i][0] > 0);
    }
    printf("%d: %u of %u lit pixels are dark\n", off, dark, lit);
    assert_true(lit > width * height / 2);
    assert_int_equal(dark, 0);
    picture_free(&a);
    picture_free(&b);
    scene_free(&scene);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(lights_in_walls_are_judged_alike),
      cmocka_unit_test(what_a_light_lies_on_does_not_shadow_it),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

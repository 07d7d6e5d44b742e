// Hybrid reflections against those of rays: the same picture to the eye, most of it without a traced ray.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "plan/reflection_cost.h"
#include "render/reflector_shape.h"
#include "scene/scene_build.h"
#include "support/mirrors.h"

enum { CUBE_PX = 128 };

// Renders by rays and by hybrid reflections: no pixel is off, and no more than `traced_most` of the rays are traced.
static void scene_check(const char *name, const Scene *scene, const Camera *camera, uint32_t lanes, double traced_most)
{
  MirrorsShown *rays = mirrors_shown(scene, camera, REFLECTIONS_RAYS, 0, lanes, 1);
  MirrorsShown *hybrid = mirrors_shown(scene, camera, REFLECTIONS_HYBRID, CUBE_PX, lanes, 1);
  size_t off = mirrors_off(rays, hybrid);
  print_message("%s: %zu pixels off, %.0f rays, %.3f traced, %.3f shaded\n", name, off, hybrid->rays,
                hybrid->traced / hybrid->rays, hybrid->shaded / hybrid->rays);
  assert_true(hybrid->rays > 1500);
  if (off > 0 || hybrid->traced > traced_most * hybrid->rays)
    fail_msg("%s: %zu pixels off, %g traced", name, off, hybrid->traced / hybrid->rays);
  free(rays);
  free(hybrid);
}

static const Vec3 room_low = {-1.9, -1.2, -2.3}, room_high = {2.4, 1.6, 1.7};

// Six lit walls of a material, which face the inside.
static void walls_add(Scene *scene, int material)
{
  Vec3 low = room_low, size = vec3_sub(room_high, room_low);
  const Vec3 x = {size.x, 0, 0}, y = {0, size.y, 0}, z = {0, 0, size.z};
  const Vec3 walls[6][3] = {{low, y, z}, {vec3_add(low, x), z, y}, {low, z, x}, {vec3_add(low, y), x, z},
                            {low, x, y}, {vec3_add(low, z), y, x}};
  for (int i = 0; i < 6; i++) scene_add_quad(scene, material, walls[i][0], walls[i][1], walls[i][2]);
  scene_add_light(scene, light_point(vec3(1.2, 1.1, 0.9), 4));
}

static Camera camera_make(void)
{
  Camera camera = camera_perspective(vec3(0.9, 0.7, 1.5), vec3(0, -0.1, 0), 0.6);
  camera.znear_m = 0.01;
  return camera;
}

static Scene room_scene(double roughness)
{
  Scene scene = scene_empty();
  walls_add(&scene, scene_add_material(&scene, material_plain(vec3(0.7, 0.6, 0.5), roughness < 1, roughness)));
  return scene;
}

// A ball among boxes that cast shadows, some of them before each other.
static void a_room_is_that_of_rays(void **state)
{
  static const uint32_t widths[] = {0, 8, 1};
  for (int i = 0; i < 3; i++) {
    Scene scene = room_scene(1);
    Camera camera = camera_make();
    int red = scene_add_material(&scene, material_plain(vec3(0.8, 0.1, 0.1), 0, 1));
    int green = scene_add_material(&scene, material_plain(vec3(0.1, 0.7, 0.2), 0, 1));
    scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, -0.1, 0), 0.4, 32);
    scene_add_box(&scene, red, vec3(0.8, -1.2, 0.2), vec3(1.1, -0.5, 0.5));
    scene_add_box(&scene, green, vec3(1.3, -1.2, 0), vec3(1.7, 0, 0.4));
    scene_add_box(&scene, green, vec3(-0.9, -1.2, 0.6), vec3(-0.7, 0.5, 0.8));
    scene_check("room", &scene, &camera, widths[i], 0.05);
    scene_free(&scene);
  }
}

// Walls of rough metal look different from each place: what the cube shows of them is right from its centre alone.
static void shine_is_not_taken_from_the_map(void **state)
{
  Scene scene = room_scene(0.5);
  Camera camera = camera_make();
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, -0.1, 0), 0.4, 32);
  scene_check("metal walls", &scene, &camera, 0, 0.05);
  MirrorsShown *impostor = mirrors_shown(&scene, &camera, REFLECTIONS_IMPOSTOR, CUBE_PX, 0, 1);
  MirrorsShown *rays = mirrors_shown(&scene, &camera, REFLECTIONS_RAYS, 0, 0, 1);
  assert_true(mirrors_off(impostor, rays) > 200);
  free(impostor);
  free(rays);
  scene_free(&scene);
}

// Of two balls that are one object each shows the other, which is not in its cube; other mirrors are, but as they look
// from its centre.
static void mirrors_in_mirrors_are_right(void **state)
{
  for (int joined = 0; joined < 2; joined++) {
    Scene scene = room_scene(1);
    Camera camera = camera_make();
    int mirror = mirrors_material(&scene, false);
    scene_add_sphere(&scene, mirror, vec3(-0.3, -0.1, 0), 0.27, 32);
    scene_add_sphere(&scene, mirror, vec3(0.3, -0.1, 0), 0.27, 32);
    if (joined) scene_join_last(&scene);
    scene_check(joined ? "two balls in one" : "two balls", &scene, &camera, 0, 0.05);
    scene_free(&scene);
  }
}

// Boxes that stand out of a wall by a hundredth of the way to it: their sides are not in the map.
static void a_step_hides_its_side(void **state)
{
  Scene scene = room_scene(1);
  Camera camera = camera_make();
  int black = scene_add_material(&scene, material_glowing(vec3(0, 0, 0)));
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, -0.1, 0), 0.7, 32);
  for (int i = -6; i < 6; i++) scene_add_box(&scene, black, vec3(0.25 * i, -1.2, 1.62), vec3(0.25 * i + 0.1, 1.6, 1.7));
  scene_check("pilasters", &scene, &camera, 0, 0.05);
  scene_free(&scene);
}

// Cards of which the ball's centre sees the edge alone, and needles as thin as a tenth of a texel, upright and aslant.
static void what_is_thinner_than_a_texel_is_seen(void **state)
{
  static const uint32_t widths[] = {0, 8, 1};
  for (int i = 0; i < 3; i++) {
    Scene scene = room_scene(1);
    Camera camera = camera_make();
    Material both = material_glowing(vec3(3, 0.2, 0.2));
    both.double_sided = true;
    int red = scene_add_material(&scene, both);
    scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, -0.1, 0), 0.4, 32);
    for (int k = 0; k < 4; k++) {
      double turn = 0.4 + 0.5 * k, x = 0.8 * sin(turn), z = 0.8 * cos(turn);
      scene_add_quad(&scene, red, vec3(x, -0.5, z), vec3(0.3 * x, 0, 0.3 * z), vec3(0, 0.7, 0));
      scene_add_quad(&scene, red, vec3(1.2 * x, 0.5, 1.2 * z), vec3(0.001, 0, 0.001), vec3(0.3, 0.6, 0.1));
    }
    scene_check("cards and needles", &scene, &camera, widths[i], 0.1);
    scene_free(&scene);
  }
}

// A shell shows its own inside and rim in itself; what is cut by a mask, and what lets light through, is traced.
static void hollows_and_holes_are_right(void **state)
{
  enum { SIDES = 24 };
  Scene scene = room_scene(1);
  Camera camera = camera_make();
  Material veil = material_plain(vec3(0.2, 0.3, 0.9), 0, 1);
  veil.alpha_mode = ALPHA_BLEND;
  veil.base_color[3] = 0.5f;
  int mirror = mirrors_material(&scene, true), blue = scene_add_material(&scene, veil);
  for (int k = 0; k < SIDES; k++) {
    double a = 2 * M_PI * k / SIDES, b = 2 * M_PI * (k + 1) / SIDES;
    Vec3 low = {0.45 * cos(a), -0.4, 0.45 * sin(a)};
    scene_add_quad(&scene, mirror, low, vec3(0.45 * (cos(b) - cos(a)), 0, 0.45 * (sin(b) - sin(a))), vec3(0, 0.5, 0));
    if (k) scene_join_last(&scene);
  }
  scene_add_quad(&scene, blue, vec3(0.6, -0.7, -0.6), vec3(0.3, 0, 0.5), vec3(0, 0.9, 0));
  scene_check("a cup without a bottom", &scene, &camera, 0, 0.1);
  scene_free(&scene);
}

static void shapes_are_told_apart(void **state)
{
  Scene scene = scene_empty();
  MirrorPlane a, b;
  int one = mirrors_material(&scene, false), two = mirrors_material(&scene, true);
  uint32_t ball = scene_add_sphere(&scene, one, vec3(1, 2, 3), 0.5, 24),
           box = scene_add_box(&scene, one, vec3(0, 0, 0), vec3(1, 2, 3));
  uint32_t shell = scene_add_sphere(&scene, two, vec3(1, 2, 3), 0.5, 24);
  uint32_t sheet = scene_add_quad(&scene, two, vec3(0, 0, 1), vec3(1, 0, 0.5), vec3(0, 3, 0));
  uint32_t next = scene_add_quad(&scene, one, vec3(1, 0, 1.5), vec3(1, 0, 0.5), vec3(0, 3, 0));
  uint32_t back = scene_add_quad(&scene, one, vec3(0, 0, 1), vec3(0, 3, 0), vec3(1, 0, 0.5));
  assert_true(object_is_convex(&scene, ball) && object_is_convex(&scene, box));
  assert_true(object_is_convex(&scene, sheet) && object_is_convex(&scene, next));
  assert_false(object_is_convex(&scene, shell));  // seen from within it meets itself
  const Primitive *primitives[] = {
      scene.meshes[scene.objects[sheet].mesh].primitives, scene.meshes[scene.objects[next].mesh].primitives,
      scene.meshes[scene.objects[back].mesh].primitives, scene.meshes[scene.objects[ball].mesh].primitives};
  assert_true(plane_of_triangle(&a, &scene, sheet, primitives[0], 0));
  assert_true(plane_of_triangle(&b, &scene, sheet, primitives[0], 1) && planes_are_one(&a, &b));
  assert_true(plane_of_triangle(&b, &scene, next, primitives[1], 0) && planes_are_one(&a, &b));
  assert_true(plane_of_triangle(&b, &scene, back, primitives[2], 0) && !planes_are_one(&a, &b));
  assert_false(plane_of_triangle(&b, &scene, ball, primitives[3], 40));  // its normals are the ball's
  scene_add_sphere(&scene, one, vec3(0, 0, 0), 0.5, 8);
  uint32_t last = scene_add_sphere(&scene, one, vec3(2, 0, 0), 0.5, 8);
  scene_join_last(&scene);
  assert_false(object_is_convex(&scene, last - 1));
  scene_free(&scene);
}

// A box of which one side is seen is flat, and all of it is traced; so is what would gain nothing.
static void who_gains_nothing_has_no_map(void **state)
{
  Scene scene = room_scene(1);
  Camera camera = camera_perspective(vec3(0, 0, 1.5), vec3(0, 0, 0), 0.6);
  int mirror = mirrors_material(&scene, false);
  scene_add_box(&scene, mirror, vec3(-0.5, -0.4, -1), vec3(0.5, 0.4, 0));
  MirrorsShown *rays = mirrors_shown(&scene, &camera, REFLECTIONS_RAYS, 0, 0, 1);
  MirrorsShown *flat = mirrors_shown(&scene, &camera, REFLECTIONS_HYBRID, CUBE_PX, 0, 1);
  assert_true(flat->reflectors.flat == 1 && flat->reflectors.visible == 1 && flat->reflectors.bytes == 0);
  assert_int_equal(mirrors_off(rays, flat), 0);
  scene_add_sphere(&scene, mirror, vec3(0.4, 0, 0.5), 0.1, 8);
  MirrorsShown *small = mirrors_shown(&scene, &camera, REFLECTIONS_HYBRID, 0, 0, 1);
  assert_true(small->reflectors.visible == 2 && small->reflectors.flat == 1);
  assert_true(small->reflectors.without_gain == 1 && small->reflectors.bytes == 0);
  assert_true(small->reflectors.hybrid_ms > small->reflectors.rays_ms && small->reflectors.rays_ms > 0);
  free(rays);
  free(flat);
  free(small);
  scene_free(&scene);
}

// The longer a map is used, the more it pays.
static void costs_grow_with_what_is_done(void **state)
{
  ReflectionFacts facts = {.rays = 1e5, .size_px = 128, .triangles = 100000, .lights = 2};
  for (int gpu = 0; gpu < 2; gpu++) {
    facts.gpu = gpu;
    ReflectionCost cost = reflection_cost(&facts), more;
    facts.rays *= 10;
    more = reflection_cost(&facts);
    assert_true(more.rays_ms > 9 * cost.rays_ms && more.hybrid_ms < 10 * cost.hybrid_ms);
    facts.rays /= 10;
    facts.size_px *= 2;
    assert_true(reflection_cost(&facts).hybrid_ms > cost.hybrid_ms);
    facts.size_px /= 2;
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_room_is_that_of_rays),
      cmocka_unit_test(shine_is_not_taken_from_the_map),
      cmocka_unit_test(mirrors_in_mirrors_are_right),
      cmocka_unit_test(a_step_hides_its_side),
      cmocka_unit_test(what_is_thinner_than_a_texel_is_seen),
      cmocka_unit_test(hollows_and_holes_are_right),
      cmocka_unit_test(shapes_are_told_apart),
      cmocka_unit_test(who_gains_nothing_has_no_map),
      cmocka_unit_test(costs_grow_with_what_is_done),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

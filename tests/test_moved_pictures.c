// A picture does not tell which frames were rendered before it: by each method, a scene that has followed a few moves,
// its trees refitted, gives the bytes of one made anew.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "device_scene/device_scene.h"
#include "scene/scene_build.h"
#include "support/effort.h"
#include "support/moved_scene.h"
#include "support/oracle_scene.h"
#include "support/picture_fixture.h"

enum { WIDTH = 96, HEIGHT = 64, BOXES = 12 };

typedef struct Room {
  Scene scene;
  uint32_t mirror, boxes[BOXES];
  Camera camera;
} Room;

// With a box of glass, or without: kernels of surfaces that let light through are others.
static void room_make(Room *out, bool has_glass)
{
  Scene *scene = &out->scene;
  *scene = scene_empty();
  scene_set_constant(scene, 0.2, 0.3, 0.5);
  Material glass = material_plain(vec3(0.5, 0.9, 0.6), 0, 0.6);
  glass.alpha_mode = ALPHA_BLEND;
  glass.base_color[3] = 0.5f;
  scene_add_material(scene, material_plain(vec3(0.7, 0.6, 0.5), 0, 0.9));
  scene_add_material(scene, material_plain(vec3(0.9, 0.9, 0.9), 1, 0));
  scene_add_material(scene, material_plain(vec3(0.9, 0.7, 0.3), 1, 0.4));
  if (has_glass) scene_add_material(scene, glass);
  scene_add_quad(scene, 0, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8));
  scene_add_quad(scene, 1, vec3(-3, 0.5, -3.9), vec3(6, 0, 0), vec3(0, 3, 0));
  out->mirror = scene_add_sphere(scene, 1, vec3(0, 1, 0), 1, 16);
  scene_add_sphere(scene, 2, vec3(-2, 0.7, 1), 0.7, 12);
  for (int i = 0; i < BOXES; i++) {
    Vec3 low = vec3(-3 + 0.5 * i, 0.05 + 0.1 * (i % 3), 1.5 - 0.7 * (i % 5));
    out->boxes[i] =
        scene_add_box(scene, i == 5 && has_glass ? 3 : 0, low, vec3_add(low, vec3(0.3, 0.4 + 0.1 * i, 0.3)));
  }
  scene_add_light(scene, light_point(vec3(1, 3, 2), 60));
  scene_add_light(scene, light_directional(vec3(0.4, -1, -0.3), 2));
  out->camera = camera_perspective(vec3(1, 2, 6), vec3(0, 0.8, 0), 0.8);
  picture_assert_ok(scene_check_complete(scene, &picture_log));
}

static void room_pose(Room *room, int frame)
{
  for (int i = 0; i < BOXES; i++) {
    const double turn = 0.1 * frame * (i % 4);
    room->scene.objects[room->boxes[i]].world_from_object = mat4_from_trs(
        vec3(0.03 * frame, 0.02 * frame * (i % 3), 0), (double[4]){0, sin(turn / 8), 0, cos(turn / 8)}, vec3(1, 1, 1));
  }
  room->scene.objects[room->mirror].world_from_object.m[12] = 0.07 * frame;
  room->scene.lights[0].position_world.x = 1 - 0.1 * frame;
}

typedef struct Methods {
  PrimaryMethod primary;
  ShadowMethod shadows;
  ReflectionMethod reflections;
} Methods;

// The sums of a frame, which stays: `before` is the frame before, or NULL.
static Float4 *frame_of(Frame *frame, Frame *before, const Room *room, const DeviceScene *scene, Device *device,
                        const Methods *methods)
{
  PictureRequest request = picture_request(WIDTH, HEIGHT, 2);
  RenderSettings *settings = &request.settings;
  settings->primary = methods->primary;
  settings->shadows = methods->shadows;
  settings->reflections = methods->reflections;
  settings->shadow_options.light_radius_m = 0.1f;
  const SceneFacts facts = {.light_count = scene->light_count,
                            .has_mirrors = scene->has_mirrors,
                            .has_blends = scene->has_blends,
                            .least_roughness = scene->least_roughness,
                            .environment_lights = scene->environment_lights};
  const FrameRequest frame_request = {.camera = &room->camera,
                                      .area = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT},
                                      .samples = 2,
                                      .before = before,
                                      .plan = plan_make(settings, &facts)};
  picture_assert_ok(frame_make(frame, device, scene, &frame_request, &picture_log));
  picture_assert_ok(frame_render(frame, &picture_log));
  Float4 *sums = oracle_array(WIDTH * HEIGHT, sizeof *sums);
  picture_assert_ok(buffer_read(device, &frame->film.sums, sums, WIDTH * HEIGHT * sizeof *sums, &picture_log));
  return sums;
}

static Float4 *picture_of(const Room *room, const DeviceScene *scene, Device *device, const Methods *methods)
{
  Frame frame = {0};
  Float4 *sums = frame_of(&frame, NULL, room, scene, device, methods);
  frame_free(&frame);
  return sums;
}

static const Methods ray_methods[] = {
    {PRIMARY_RAYS, SHADOWS_RAYS, REFLECTIONS_RAYS},       {PRIMARY_RASTER, SHADOWS_HYBRID, REFLECTIONS_HYBRID},
    {PRIMARY_RASTER, SHADOWS_RAYS, REFLECTIONS_MIXED},    {PRIMARY_RAYS, SHADOWS_HYBRID, REFLECTIONS_CANDIDATES},
    {PRIMARY_RASTER, SHADOWS_HYBRID, REFLECTIONS_PLANAR},
};
static const Methods map_methods[] = {
    {PRIMARY_RASTER, SHADOWS_MAP, REFLECTIONS_CUBE},
    {PRIMARY_RASTER, SHADOWS_PCF, REFLECTIONS_BOX},
    {PRIMARY_RASTER, SHADOWS_PCSS, REFLECTIONS_IMPOSTOR},
    {PRIMARY_RASTER, SHADOWS_AREA, REFLECTIONS_SNAPSHOT},
};

static void assert_same_pictures(const Room *room, const DeviceScene *moved, const DeviceScene *fresh, Device *device,
                                 const Methods *methods, size_t count)
{
  for (size_t m = 0; m < count; m++) {
    Float4 *a = picture_of(room, moved, device, &methods[m]), *b = picture_of(room, fresh, device, &methods[m]);
    uint32_t differ = 0, dark = 0;
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
      differ += memcmp(&a[i], &b[i], sizeof a[i]) != 0;
      dark += a[i].x == 0;
    }
    if (differ) fail_msg("methods %zu, lanes %u: %u pixels differ", m, device_traits(device)->lanes, differ);
    assert_true(dark < WIDTH * HEIGHT / 2);
    free(a);
    free(b);
  }
}

// Else there is nothing to tell.
static void assert_other_order(const DeviceScene *a, const DeviceScene *b, Device *device)
{
  void *x = buffer_copied(device, &a->bvh2_triangles), *y = buffer_copied(device, &b->bvh2_triangles);
  assert_int_equal(a->bvh2_triangles.bytes, b->bvh2_triangles.bytes);
  assert_memory_not_equal(x, y, a->bvh2_triangles.bytes);
  free(x);
  free(y);
}

static void moved_check(bool has_glass, uint32_t lanes, const Methods *methods, size_t count)
{
  Room room;
  Device *device = picture_device(lanes);
  DeviceScene moved, fresh;
  Timeline timeline = {0};
  room_make(&room, has_glass);
  room_pose(&room, 0);
  picture_assert_ok(device_scene_make_movable(&moved, device, &room.scene, NULL, &picture_log));
  for (int frame = 1; frame <= 3; frame++) {
    room_pose(&room, frame);
    picture_assert_ok(device_scene_move(&moved, device, &timeline, &picture_log));
    assert_int_equal(moved.mover_count, BOXES + 1);
  }
  for (size_t i = 0; i < timeline.count; i++)
    if (!strcmp(timeline.spans[i].name, "build the BVH")) fail_msg("the tree was built anew, not refitted");
  timeline_free(&timeline);
  picture_assert_ok(device_scene_make(&fresh, device, &room.scene, NULL, &picture_log));
  assert_other_order(&moved, &fresh, device);
  assert_same_pictures(&room, &moved, &fresh, device, methods, count);
  device_scene_free(&fresh);
  device_scene_free(&moved);
  scene_free(&room.scene);
}

static void pictures_do_not_tell_what_was_before(void **state)
{
  moved_check(true, 0, ray_methods, sizeof ray_methods / sizeof *ray_methods);
  moved_check(false, 0, map_methods, sizeof map_methods / sizeof *map_methods);
  moved_check(false, 1, ray_methods, sizeof ray_methods / sizeof *ray_methods);
}

// Views of the lamp's hybrid maps that stayed, but for those in which nothing is drawn.
static uint32_t drawn_views_kept(const Frame *frame)
{
  const SureMaps *maps = &frame->shadow_hybrid.maps;
  uint32_t kept = 0;
  for (uint32_t view = 0; view < maps->lights[0].view_count; view++)
    kept += maps->stayed[0][view] && maps->view_blocks[0][view].count > 0;
  assert_in_range(kept, 0, sure_maps_kept(maps, 0));
  return kept;
}

// Boxes on the left move, one of them out of the tree and back, which then is built anew.
static void boxes_move(Room *room, int step)
{
  for (int i = 0; i < 3; i++)
    room->scene.objects[room->boxes[i]].world_from_object =
        mat4_from_trs(vec3(i == 1 && step == 2 ? INFINITY : 0, 0.07 * step, 0), (double[4]){0, 0, 0, 1}, vec3(1, 1, 1));
}

// Slots of which a verdict is kept.
static uint32_t verdicts_known(const Frame *frame, Device *device)
{
  const KeptVerdicts *kept = &frame->shadow_hybrid.verdicts;
  uint32_t known = 0;
  if (!kept->slots) return 0;
  uint32_t *words = malloc(kept->words.bytes);
  assert_non_null(words);
  picture_assert_ok(buffer_read(device, &kept->words, words, kept->words.bytes, &picture_log));
  for (size_t i = 0; i < kept->slots; i++) known += words[(size_t)VERDICT_KNOWN * kept->slots + i] != 0;
  free(words);
  return known;
}

// Hybrid maps name triangles by where they lie in the tree: while it is refitted, views that see nothing that moved
// stay, and so do verdicts on rays in them; others are judged anew.
static void maps_and_verdicts_stay_while_the_tree_is_refitted(uint32_t lanes, bool shadowless)
{
  static const Methods methods = {PRIMARY_RASTER, SHADOWS_HYBRID, REFLECTIONS_NONE};
  enum { STEPS = 7 };
  Room room;
  Device *device = picture_device(lanes);
  DeviceScene moved;
  Frame before = {0};
  room_make(&room, true);
  room.scene.lights[0].position_world = vec3(0.6, 1.2, 2);
  for (int i = 0; i < 3; i++) room.scene.objects[room.boxes[i]].shadowless = shadowless;
  picture_assert_ok(device_scene_make_movable(&moved, device, &room.scene, NULL, &picture_log));
  for (int step = 0; step < STEPS; step++) {
    Frame frame = {0};
    DeviceScene fresh;
    boxes_move(&room, step);
    if (step) picture_assert_ok(device_scene_move(&moved, device, NULL, &picture_log));
    assert_int_equal(moved.trees_rebuilt, step == 2 || step == 3);
    Float4 *sums = frame_of(&frame, step ? &before : NULL, &room, &moved, device, &methods);
    picture_assert_ok(device_scene_make(&fresh, device, &room.scene, NULL, &picture_log));
    Float4 *alone = picture_of(&room, &fresh, device, &methods);
    if (memcmp(sums, alone, WIDTH * HEIGHT * sizeof *sums)) fail_msg("step %d: another picture", step);
    const uint32_t views = drawn_views_kept(&frame);
    if (step == 0 || moved.trees_rebuilt)
      assert_int_equal(views, 0);
    else
      assert_in_range(views, 2, shadowless ? 6 : 4);
    assert_true((views > 0) == (verdicts_known(&frame, device) > WIDTH * HEIGHT / 4));
    free(sums);
    free(alone);
    device_scene_free(&fresh);
    frame_free(&before);
    before = frame;
  }
  frame_free(&before);
  device_scene_free(&moved);
  scene_free(&room.scene);
}

static void hybrid_maps_stay_while_the_tree_is_refitted(void **state)
{
  maps_and_verdicts_stay_while_the_tree_is_refitted(0, false);
  if (!effort_is_quick()) maps_and_verdicts_stay_while_the_tree_is_refitted(1, false);
}

// What casts no shadow leaves all maps as they are, and is seen with the shadows that are where it comes to.
static void what_casts_no_shadow_moves_through_kept_ones(void **state)
{
  maps_and_verdicts_stay_while_the_tree_is_refitted(0, true);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pictures_do_not_tell_what_was_before),
      cmocka_unit_test(hybrid_maps_stay_while_the_tree_is_refitted),
      cmocka_unit_test(what_casts_no_shadow_moves_through_kept_ones),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

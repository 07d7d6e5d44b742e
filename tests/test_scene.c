// The scene model: counts, bounds, and what a scene gets when nothing is said.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_defaults.h"

static char notes[1024];

static void note_keep(void *context, LogLevel level, const char *message)
{
  if (level == LOG_INFO) strncat(notes, message, sizeof notes - strlen(notes) - 1);
}

static Log log_make(void)
{
  notes[0] = 0;
  return (Log){.sink = note_keep};
}

// One triangle (0,0,0) (4,0,0) (0,2,0), drawn as it is and moved by (0, 0, -6); a fourth vertex is used by nothing.
static float positions[4][3] = {{0, 0, 0}, {4, 0, 0}, {0, 2, 0}, {99, 99, 99}};
static uint32_t triangles[1][3] = {{0, 1, 2}};
static Primitive primitive = {.vertex_count = 4, .triangle_count = 1, .positions = positions, .triangles = triangles};
static Mesh mesh = {.primitives = &primitive, .primitive_count = 1};
static Object objects[2] = {{.world_from_object = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}},
                            {.world_from_object = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -6, 1}}}};
static Camera cameras[2] = {{.name = "nave", .yfov_rad = 0.5}, {.name = "mirror", .yfov_rad = 0.75}};

static Scene scene_make(void)
{
  return (Scene){.path = "test.glb",
                 .meshes = &mesh,
                 .mesh_count = 1,
                 .objects = objects,
                 .object_count = 2,
                 .cameras = cameras,
                 .camera_count = 2};
}

static void counts_and_bounds_go_by_what_is_drawn(void **state)
{
  Scene scene = scene_make(), empty = {0};
  Vec3 low = vec3(7, 7, 7), high = low;
  assert_int_equal(scene_triangle_count(&scene), 2);
  assert_int_equal(scene_triangle_count(&empty), 0);
  assert_false(scene_bounds(&empty, &low, &high));
  assert_true(low.x == 7 && high.z == 7);
  assert_true(scene_bounds(&scene, &low, &high));
  assert_true(low.x == 0 && low.y == 0 && low.z == -6 && high.x == 4 && high.y == 2 && high.z == 0);
}

static void cameras_are_chosen_by_default_index_and_name(void **state)
{
  Scene scene = scene_make();
  Log log = log_make();
  Camera camera;
  assert_int_equal(scene_camera_choose(&camera, &scene, NULL, 1, &log), STATUS_OK);
  assert_string_equal(camera.name, "nave");
  assert_int_equal(scene_camera_choose(&camera, &scene, "1", 1, &log), STATUS_OK);
  assert_string_equal(camera.name, "mirror");
  assert_int_equal(scene_camera_choose(&camera, &scene, "mirror", 1, &log), STATUS_OK);
  assert_true(camera.yfov_rad == 0.75);
}

static void unknown_cameras_name_the_nearest(void **state)
{
  const struct {
    const char *choice, *message;
  } cases[] = {{"miror", "test.glb: no camera 'miror': did you mean 'mirror'?"},
               {"Fit", "no camera 'Fit': did you mean 'fit'?"},
               {"2", "no camera 2: the scene has 2, numbered from 0"},
               {"99999999999999999999", "the scene has 2"},
               {"-1", "no camera '-1'"}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    Scene scene = scene_make();
    Log log = log_make();
    Camera camera = {.yfov_rad = 77};
    assert_int_equal(scene_camera_choose(&camera, &scene, cases[i].choice, 1, &log), STATUS_USAGE);
    if (!strstr(log.error, cases[i].message)) fail_msg("'%s' without '%s'", log.error, cases[i].message);
    assert_true(camera.yfov_rad == 77);
  }
}

// Largest |x| or |y| of the corners of the scene's bounds in the picture, where 1 is an edge; each must lie within the
// depth range.
static double corners_reach(const Camera *camera, const Scene *scene, double aspect)
{
  Vec3 low = vec3(-1, -1, -1), high = vec3(1, 1, 1);
  double reach = 0, tan_y = tan(camera->yfov_rad / 2);
  const double *m = camera->world_from_camera.m;
  scene_bounds(scene, &low, &high);
  for (int i = 0; i < 8; i++) {
    Vec3 corner = vec3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
    Vec3 p = vec3_sub(corner, vec3(m[12], m[13], m[14]));
    double x = vec3_dot(p, vec3(m[0], m[1], m[2])), y = vec3_dot(p, vec3(m[4], m[5], m[6]));
    double depth = -vec3_dot(p, vec3(m[8], m[9], m[10]));
    assert_true(depth > camera->znear_m && depth < camera->zfar_m);
    reach = fmax(reach, fmax(fabs(x) / (tan_y * aspect * depth), fabs(y) / (tan_y * depth)));
  }
  return reach;
}

static void fitted_views_hold_the_bounds_with_a_margin(void **state)
{
  const double aspects[] = {16.0 / 9, 1, 0.25, 10};
  const double scales[] = {1, 1e-4, 1e6};
  for (size_t i = 0; i < 12; i++) {
    Scene scene = scene_make();
    Object scaled[2] = {objects[0], objects[1]};
    Log log = log_make();
    Camera camera;
    for (int o = 0; o < 2; o++)
      for (int e = 0; e < 15; e++) scaled[o].world_from_object.m[e] *= scales[i / 4];
    scene.objects = scaled;
    assert_int_equal(scene_camera_choose(&camera, &scene, "fit", aspects[i % 4], &log), STATUS_OK);
    assert_true(fabs(mat4_determinant3(&camera.world_from_camera) - 1) < 1e-9);
    assert_true(camera.world_from_camera.m[5] > 0.5);   // upright
    assert_true(camera.world_from_camera.m[8] > 0.1);   // from the right
    assert_true(camera.world_from_camera.m[9] > 0.1);   // from above
    assert_true(camera.world_from_camera.m[10] > 0.5);  // from the front
    double reach = corners_reach(&camera, &scene, aspects[i % 4]);
    if (fabs(reach - 0.95) > 1e-9) fail_msg("the corners reach %g of the half picture", reach);
  }
}

static void nothing_and_a_point_can_be_fitted(void **state)
{
  Scene empty = {.path = "test.glb"}, point = scene_make();
  float same[3][3] = {{500, 500, 500}, {500, 500, 500}, {500, 500, 500}};
  Primitive dot = primitive;
  Mesh dots = {.primitives = &dot, .primitive_count = 1};
  dot.positions = same;
  point.meshes = &dots;
  point.object_count = 1;
  Log log = log_make();
  Camera camera;
  assert_int_equal(scene_camera_choose(&camera, &empty, NULL, 1.5, &log), STATUS_OK);
  assert_true(fabs(corners_reach(&camera, &empty, 1.5) - 0.95) < 1e-9);
  assert_int_equal(scene_camera_choose(&camera, &point, "fit", 1.5, &log), STATUS_OK);
  assert_true(corners_reach(&camera, &point, 1.5) < 0.95);
  assert_true(camera.znear_m > 0 && camera.world_from_camera.m[14] > 500);
}

static void scenes_with_lights_are_black_elsewhere(void **state)
{
  Light lamp = {.kind = LIGHT_POINT};
  Scene scene = {.path = "test.glb", .lights = &lamp, .light_count = 1};
  Log log = log_make();
  assert_int_equal(scene_add_default_lighting(&scene, true, &log), STATUS_OK);
  assert_int_equal(scene.light_count, 1);
  assert_int_equal(scene.environment.kind, ENVIRONMENT_CONSTANT);
  for (int c = 0; c < 3; c++) assert_true(scene.environment.constant[c] == 0);
  assert_string_equal(notes, "");
}

// Radiance that a white diffuse surface with normal n reflects: the sky over its hemisphere, summed up, and the sun.
static double white_radiance(const Scene *scene, Vec3 n, int c)
{
  enum { ROWS = 200, COLUMNS = 400 };
  const Environment *sky = &scene->environment;
  double irradiance = 0;
  for (int row = 0; row < ROWS; row++)
    for (int column = 0; column < COLUMNS; column++) {
      double y = 2 * (row + 0.5) / ROWS - 1, p = 2 * M_PI * column / COLUMNS, side = sqrt(1 - y * y);
      double cosine = vec3_dot(n, vec3(side * cos(p), y, side * sin(p)));
      double pole = y > 0 ? sky->zenith[c] : sky->ground[c];
      double radiance = sky->intensity * (sky->horizon[c] + fabs(y) * (pole - sky->horizon[c]));
      irradiance += fmax(cosine, 0) * radiance * 4 * M_PI / (ROWS * COLUMNS);
    }
  for (uint32_t i = 0; i < scene->light_count; i++)
    irradiance += fmax(0, -vec3_dot(n, scene->lights[i].direction_world)) * scene->lights[i].intensity *
                  scene->lights[i].color[c];
  return irradiance / M_PI;
}

static void scenes_without_lights_get_a_sky_and_a_sun(void **state)
{
  Scene scene = {.path = strdup("test.glb")};
  Log log = log_make();
  assert_int_equal(scene_add_default_lighting(&scene, true, &log), STATUS_OK);
  assert_string_equal(notes, "test.glb: has no lights: lit by the built-in sky and sun");
  assert_int_equal(scene.light_count, 1);
  assert_int_equal(scene.lights[0].kind, LIGHT_DIRECTIONAL);
  double brightest = 0;
  for (int i = 0; i < 26; i++) {
    Vec3 n = vec3_unit_or(vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1), scene.lights[0].direction_world);
    for (int c = 0; c < 3; c++) brightest = fmax(brightest, white_radiance(&scene, n, c));
  }
  for (int c = 0; c < 3; c++)
    brightest = fmax(brightest, white_radiance(&scene, vec3_neg(scene.lights[0].direction_world), c));
  if (!(brightest > 0.9 && brightest < 1)) fail_msg("a white surface reaches %g", brightest);
  scene_free(&scene);
}

static void the_sun_can_be_left_out(void **state)
{
  Scene scene = {.path = "test.glb"};
  Log log = log_make();
  assert_int_equal(scene_add_default_lighting(&scene, false, &log), STATUS_OK);
  assert_int_equal(scene.light_count, 0);
  assert_int_equal(scene.environment.kind, ENVIRONMENT_GRADIENT);
  double up = M_PI * white_radiance(&scene, vec3(0, 1, 0), 1);
  if (fabs(up - 1) > 0.1) fail_msg("the sky's irradiance from above is %g", up);
  assert_null(strstr(notes, "sun"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(counts_and_bounds_go_by_what_is_drawn),
      cmocka_unit_test(cameras_are_chosen_by_default_index_and_name),
      cmocka_unit_test(unknown_cameras_name_the_nearest),
      cmocka_unit_test(fitted_views_hold_the_bounds_with_a_margin),
      cmocka_unit_test(nothing_and_a_point_can_be_fitted),
      cmocka_unit_test(scenes_with_lights_are_black_elsewhere),
      cmocka_unit_test(scenes_without_lights_get_a_sky_and_a_sun),
      cmocka_unit_test(the_sun_can_be_left_out),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

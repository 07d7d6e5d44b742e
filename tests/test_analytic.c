// Pictures whose every pixel follows from a formula: what is where, and how bright.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "shared/aov.h"
#include "support/gltf_build.h"
#include "support/oracle_camera.h"
#include "support/picture_fixture.h"

enum { SURFACE_AOVS = AOV_NAME_SHADOW - 1 };

static Vec3 along(const OracleRay *ray, double t) { return vec3_add(ray->origin, vec3_scale(ray->direction, t)); }

static OracleRay pixel_ray(const Camera *camera, const Picture *picture, uint32_t x, uint32_t y)
{
  return oracle_camera_ray(camera, picture->width, picture->height, x + 0.5, y + 0.5);
}

// ---- a sphere on a plane --------------------------------------------------------------------------------------------

enum { FLOOR, BALL, RINGS = 64 };
#define FLOOR_HALF_M 4.0
#define BALL_RADIUS_M 1.0

static Scene ball_scene(void)
{
  Scene scene = scene_empty();
  int floor = scene_add_material(&scene, material_plain(vec3(0.8, 0.5, 0.2), 0, 1));
  int ball = scene_add_material(&scene, material_plain(vec3(0.2, 0.6, 0.9), 0, 1));
  scene_add_quad(&scene, floor, vec3(-FLOOR_HALF_M, 0, FLOOR_HALF_M), vec3(2 * FLOOR_HALF_M, 0, 0),
                 vec3(0, 0, -2 * FLOOR_HALF_M));
  scene_add_sphere(&scene, ball, vec3(0, BALL_RADIUS_M, 0), BALL_RADIUS_M, RINGS);
  return scene;
}

// What a ray meets by the formulas.
typedef struct Sight {
  uint32_t object;
  double t;
  Vec3 normal;
  double margin;   // of the verdict, metres across the ray
  double slack_m;  // how much farther the mesh of the ball may be
} Sight;

static Sight sight_of(const OracleRay *ray)
{
  Sight sight = {.object = AOV_NONE, .t = INFINITY, .margin = INFINITY};
  Vec3 center = vec3(0, BALL_RADIUS_M, 0), to_center = vec3_sub(center, ray->origin);
  double length = vec3_length(ray->direction), middle = vec3_dot(to_center, ray->direction) / (length * length);
  double miss_m = vec3_length(vec3_sub(along(ray, middle), center));
  double plane = -ray->origin.y / ray->direction.y;
  Vec3 at = along(ray, plane);
  double inset = FLOOR_HALF_M - fmax(fabs(at.x), fabs(at.z));
  sight.margin = fabs(miss_m - BALL_RADIUS_M);
  if (miss_m < BALL_RADIUS_M) {
    sight.object = BALL;
    double least_m = BALL_RADIUS_M * (2 * cos(M_PI / 2 / RINGS) - 1);
    double half_m = sqrt(BALL_RADIUS_M * BALL_RADIUS_M - miss_m * miss_m);
    sight.t = middle - half_m / length;
    sight.normal = vec3_sub(along(ray, sight.t), center);
    sight.slack_m = half_m - sqrt(fmax(0, least_m * least_m - miss_m * miss_m));
  } else if (plane > 0 && inset > 0) {
    sight.object = FLOOR;
    sight.t = plane;
    sight.normal = vec3(0, 1, 0);
    sight.margin = fmin(sight.margin, inset);
  } else if (plane > 0) {
    sight.margin = fmin(sight.margin, -inset);
  }
  return sight;
}

static double off(const float got[3], Vec3 wanted)
{
  return fmax(fabs(got[0] - wanted.x), fmax(fabs(got[1] - wanted.y), fabs(got[2] - wanted.z)));
}

static void layer_at(float out[3], const Picture *picture, const char *const names[3], size_t pixel)
{
  for (int i = 0; i < 3; i++) out[i] = picture_floats(picture, names[i])[pixel];
}

static void sight_check(const Picture *picture, const Sight *sight, const OracleRay *ray, size_t pixel)
{
  float position[3], normal[3], albedo[3];
  layer_at(position, picture, (const char *const[]){"position.X", "position.Y", "position.Z"}, pixel);
  layer_at(normal, picture, (const char *const[]){"normal.X", "normal.Y", "normal.Z"}, pixel);
  layer_at(albedo, picture, (const char *const[]){"albedo.R", "albedo.G", "albedo.B"}, pixel);
  double depth = picture_floats(picture, "depth.Z")[pixel];
  assert_int_equal(picture_integers(picture, "object.id")[pixel], sight->object);
  assert_true(picture->radiance[pixel][3] == (sight->object == AOV_NONE ? 0 : 1));
  if (sight->object == AOV_NONE) {
    assert_true(isinf(depth) && depth > 0 && off(normal, vec3(0, 0, 0)) == 0 && off(albedo, vec3(0, 0, 0)) == 0);
    assert_int_equal(picture_integers(picture, "primitive.id")[pixel], AOV_NONE);
    assert_int_equal(picture_integers(picture, "material.id")[pixel], AOV_NONE);
    return;
  }
  assert_int_equal(picture_integers(picture, "material.id")[pixel], sight->object);
  double allowed = 1e-5 * sight->t + sight->slack_m / vec3_length(ray->direction);
  if (!(fabs(depth - sight->t) <= allowed)) fail_msg("pixel %zu: depth %g, not %g", pixel, depth, sight->t);
  assert_true(off(position, along(ray, depth)) <= 1e-5);
  assert_true(off(normal, sight->normal) <= 1e-6 + 2 * sight->slack_m);
  assert_true(off(albedo, sight->object == BALL ? vec3(0.2, 0.6, 0.9) : vec3(0.8, 0.5, 0.2)) <= 1e-6);
}

// Silhouette, depth, position and normal, in every pixel that is no nearer to an edge than the mesh is to a ball.
static void ball_check(Camera camera)
{
  Scene scene = ball_scene();
  PictureRequest request = picture_request(107, 71, 1);  // no multiple of a tile
  request.aovs = SURFACE_AOVS;
  Picture picture = picture_render(&scene, &camera, &request);
  uint32_t seen[3] = {0}, unsure = 0;
  for (uint32_t y = 0; y < picture.height; y++) {
    for (uint32_t x = 0; x < picture.width; x++) {
      OracleRay ray = pixel_ray(&camera, &picture, x, y);
      Sight sight = sight_of(&ray);
      seen[sight.object == AOV_NONE ? 2 : sight.object]++;
      if (sight.margin > 0.002)
        sight_check(&picture, &sight, &ray, (size_t)y * picture.width + x);
      else
        unsure++;
    }
  }
  assert_true(seen[FLOOR] > 500 && seen[BALL] > 300 && seen[2] > 500 && unsure < 50);
  picture_free(&picture);
  scene_free(&scene);
}

static void a_ball_on_a_plane_is_where_perspective_puts_it(void **state)
{
  ball_check(camera_perspective(vec3(2, 3, 7), vec3(-0.3, 0.8, 0), 0.8));
}

static void a_ball_on_a_plane_is_where_parallel_rays_put_it(void **state)
{
  ball_check(camera_orthographic(vec3(3, 2.5, 4), vec3(0.2, 0.8, 0), 3));
}

// ---- lights ---------------------------------------------------------------------------------------------------------

// Exponent 0 of `phong` makes (base + 0.04) / pi of a dielectric of roughness 1, whatever the angles.
#define FLOOR_BASE 0.5
static double irradiance_of(double radiance, double base) { return radiance * M_PI / (base + 0.04); }

static PictureRequest matt_request(uint32_t width, uint32_t height)
{
  PictureRequest request = picture_request(width, height, 1);
  request.settings.lighting = LIGHTING_PHONG;
  request.settings.ambient = 0;
  return request;
}

// Irradiance on the floor by a light, from the extension's own formulas: KHR_lights_punctual.
static double floor_irradiance(const Light *light, Vec3 at)
{
  if (light->kind == LIGHT_DIRECTIONAL) return light->intensity * fmax(0, -light->direction_world.y);
  Vec3 away = vec3_sub(at, light->position_world);
  double d = vec3_length(away), cosine = -away.y / d, share = 1;
  if (isfinite(light->range_m)) share = fmax(0, fmin(1, 1 - pow(d / light->range_m, 4)));
  if (light->kind == LIGHT_SPOT) {
    double inner = cos(light->inner_cone_rad), outer = cos(light->outer_cone_rad);
    double angle = vec3_dot(away, light->direction_world) / d;
    share *= pow(fmax(0, fmin(1, (angle - outer) / (inner - outer))), 2);
  }
  return share * light->intensity * cosine / (d * d);
}

static void light_check(Light light, double least_dark, double least_lit)
{
  Scene scene = scene_empty();
  int floor = scene_add_material(&scene, material_plain(vec3(FLOOR_BASE, FLOOR_BASE, FLOOR_BASE), 0, 1));
  scene_add_quad(&scene, floor, vec3(-5, 0, 5), vec3(10, 0, 0), vec3(0, 0, -10));
  scene_add_light(&scene, light);
  Camera camera = camera_orthographic(vec3(0, 3, 0), vec3(0, 0, 0), 5);
  PictureRequest request = matt_request(65, 65);
  Picture picture = picture_render(&scene, &camera, &request);
  uint32_t dark = 0, lit = 0;
  for (uint32_t y = 0; y < 65; y++) {
    for (uint32_t x = 0; x < 65; x++) {
      Vec3 at = vec3((x + 0.5) * 10 / 65 - 5, 0, (y + 0.5) * 10 / 65 - 5);
      double wanted = floor_irradiance(&light, at), got = irradiance_of(picture_pixel(&picture, x, y)[0], FLOOR_BASE);
      dark += wanted == 0;
      lit += wanted > 0;
      if (!(fabs(got - wanted) <= 1e-4 * wanted + 1e-6)) fail_msg("(%g, %g): %g, not %g", at.x, at.z, got, wanted);
    }
  }
  assert_true(dark >= least_dark * 65 * 65 && lit >= least_lit * 65 * 65);
  picture_free(&picture);
  scene_free(&scene);
}

static void a_point_light_falls_off_with_the_square(void **state)
{
  Light light = light_point(vec3(1, 2, -0.5), 10);
  light_check(light, 0, 1);
  light.range_m = 3;
  light_check(light, 0.7, 0.1);
}

static void a_spot_light_keeps_to_its_cone(void **state)
{
  light_check(light_spot(vec3(0, 3, 0), vec3(0, 0, 0), 18, 20 * M_PI / 180, 35 * M_PI / 180), 0.8, 0.1);
  light_check(light_spot(vec3(-2, 2, 1), vec3(1, 0, 0), 30, 0, 0.6), 0.5, 0.1);
}

static void a_directional_light_is_the_same_everywhere(void **state)
{
  light_check(light_directional(vec3(-1, -1, 0), 2), 0, 1);
  light_check(light_directional(vec3(0.5, 0.1, 0), 2), 1, 0);  // from below
}

// An interpolated normal may lean to a light behind the triangle: it stays dark, with shadow rays or without.
static void a_light_behind_the_plane_does_not_light(void **state)
{
  for (int above = 0; above < 2; above++) {
    for (int shadows = 0; shadows < 2; shadows++) {
      Scene scene = scene_empty();
      int material = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
      const Vec3 corners[3] = {vec3(-9, 0, 9), vec3(9, 0, 9), vec3(0, 0, -20)}, lean = vec3(0.95, 0.3, 0);
      scene_add_triangle(&scene, material, corners, (const Vec3[3]){lean, lean, lean});
      scene_add_light(&scene, light_point(vec3(30, above ? 0.5 : -0.5, 0), 1000));
      Camera camera = camera_orthographic(vec3(0, 2, 0), vec3(0, 0, 0), 1);
      PictureRequest request = matt_request(9, 9);
      request.settings.shadows = shadows ? SHADOWS_RAYS : SHADOWS_NONE;
      Picture picture = picture_render(&scene, &camera, &request);
      for (uint32_t i = 0; i < 81; i++) assert_true(above ? picture.radiance[i][0] > 0.1 : picture.radiance[i][0] == 0);
      picture_free(&picture);
      scene_free(&scene);
    }
  }
}

// ---- shadows --------------------------------------------------------------------------------------------------------

// Does the segment meet the box, by slabs? `margin` widens it.
static bool box_blocks(Vec3 from, Vec3 to, Vec3 low, Vec3 high, double margin)
{
  const double a[3] = {from.x, from.y, from.z}, b[3] = {to.x, to.y, to.z};
  const double l[3] = {low.x, low.y, low.z}, h[3] = {high.x, high.y, high.z};
  double enter = 0, leave = 1;
  for (int axis = 0; axis < 3; axis++) {
    double d = b[axis] - a[axis], t0 = (l[axis] - margin - a[axis]) / d, t1 = (h[axis] + margin - a[axis]) / d;
    enter = fmax(enter, fmin(t0, t1));
    leave = fmin(leave, fmax(t0, t1));
  }
  return enter <= leave;
}

static void a_post_throws_its_shadow_where_it_must(void **state)
{
  Scene scene = scene_empty();
  const Vec3 low = vec3(0.8, 0, -0.3), high = vec3(1.1, 1.2, 0.2), lamp = vec3(-0.5, 2.1, 0.9);
  int floor = scene_add_material(&scene, material_plain(vec3(FLOOR_BASE, FLOOR_BASE, FLOOR_BASE), 0, 1));
  scene_add_quad(&scene, floor, vec3(-5, 0, 5), vec3(10, 0, 0), vec3(0, 0, -10));
  scene_add_box(&scene, floor, low, high);
  scene_add_light(&scene, light_point(lamp, 10));
  Camera camera = camera_perspective(vec3(-1, 4, 4), vec3(1, 0, 0), 0.9);
  for (int shadows = 0; shadows < 2; shadows++) {
    PictureRequest request = matt_request(160, 120);
    request.settings.shadows = shadows ? SHADOWS_RAYS : SHADOWS_NONE;
    Picture picture = picture_render(&scene, &camera, &request);
    uint32_t dark = 0, lit = 0;
    for (uint32_t y = 0; y < picture.height; y++) {
      for (uint32_t x = 0; x < picture.width; x++) {
        OracleRay ray = pixel_ray(&camera, &picture, x, y);
        Vec3 at = along(&ray, -ray.origin.y / ray.direction.y);
        if (ray.direction.y >= 0 || fmax(fabs(at.x), fabs(at.z)) > 4.99) continue;
        if (box_blocks(ray.origin, at, low, high, 1e-4)) continue;  // the post itself is seen
        bool in_shadow = shadows && box_blocks(lamp, at, low, high, -1e-4);
        if (!in_shadow && shadows && box_blocks(lamp, at, low, high, 1e-4)) continue;  // at its edge
        double got = irradiance_of(picture_pixel(&picture, x, y)[0], FLOOR_BASE);
        double wanted = in_shadow ? 0 : floor_irradiance(&scene.lights[0], at);
        if (!(fabs(got - wanted) <= 1e-4 * wanted)) fail_msg("(%u, %u): %g, not %g", x, y, got, wanted);
        dark += in_shadow;
        lit += !in_shadow;
      }
    }
    assert_true(lit > 5000 && (shadows ? dark > 300 : dark == 0));
    picture_free(&picture);
  }
  scene_free(&scene);
}

// ---- the shared LightTypes asset ------------------------------------------------------------------------------------

// Its floor is 10 x 10 m at y = 0, base colour 0.8; irradiance at (x, z) of it.
static double asset_irradiance(const Picture *picture, double x, double z)
{
  uint32_t column = (uint32_t)((x + 5) / 10 * picture->width), row = (uint32_t)((z + 5) / 10 * picture->height);
  return irradiance_of(picture_pixel(picture, column, row)[0], 0.8);
}

// The table of the assets' README: what each of the file's four scenes gives at (x, z) of its floor.
static const struct AssetRow {
  int scene;
  double x, z, irradiance, tolerance;
} asset_rows[] = {
    {0, 0, 0, 1.414, 1e-3},    {0, -4, 3, 1.414, 1e-3}, {0, 0.45, 0, 0, 0}, {0, 1.35, 0, 0, 0},
    {0, 0.35, 0, 1.414, 1e-3}, {1, 0, 0, 2.5, 2e-3},    {1, 3.1, 0, 0, 0},  {1, 2, 0, 0, 0},
    {1, 3.3, 0, 0.3481, 3e-3}, {2, 0, 0, 2.006, 2e-3},  {2, 0, 2.3, 0, 0},  {2, -4, -4, 0, 0},
    {3, 0, 0, 2, 2e-3},        {3, 0, 1, 1.7076, 5e-3}, {3, 0, 2.2, 0, 0},
};

static void the_light_types_asset_is_lit_as_its_table_says(void **state)
{
  const char *assets = gltf_assets();
  if (!assets) return;
  char path[512];
  snprintf(path, sizeof path, "%s/LightTypes/LightTypes.glb", assets);
  for (int number = 0; number < 4; number++) {
    gltf_options.scene = number;
    Scene scene = gltf_read_fine(path);
    assert_int_equal(scene.light_count, 1);
    Camera camera = camera_orthographic(vec3(0, 6, 0), vec3(0, 0, 0), 5);
    PictureRequest request = matt_request(501, 501);
    Picture picture = picture_render(&scene, &camera, &request);
    for (size_t i = 0; i < sizeof asset_rows / sizeof *asset_rows; i++) {
      const struct AssetRow *row = &asset_rows[i];
      if (row->scene != number) continue;
      double got = asset_irradiance(&picture, row->x, row->z);
      if (!(fabs(got - row->irradiance) <= row->tolerance))
        fail_msg("scene %d at (%g, %g): %g, not %g", number, row->x, row->z, got, row->irradiance);
    }
    picture_free(&picture);
    scene_free(&scene);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_ball_on_a_plane_is_where_perspective_puts_it),
      cmocka_unit_test(a_ball_on_a_plane_is_where_parallel_rays_put_it),
      cmocka_unit_test(a_point_light_falls_off_with_the_square),
      cmocka_unit_test(a_spot_light_keeps_to_its_cone),
      cmocka_unit_test(a_directional_light_is_the_same_everywhere),
      cmocka_unit_test(a_light_behind_the_plane_does_not_light),
      cmocka_unit_test(a_post_throws_its_shadow_where_it_must),
      cmocka_unit_test(the_light_types_asset_is_lit_as_its_table_says),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

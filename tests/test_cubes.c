// Reflections by maps against reflections by rays, which test_picture_mirrors.c holds to closed forms.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "plan/cube_error.h"
#include "scene/scene_build.h"
#include "support/oracle_camera.h"
#include "support/picture_fixture.h"

static PictureRequest request_of(uint32_t side, ReflectionMethod method, uint32_t cube_px)
{
  PictureRequest request = picture_request(side, side, 1);
  request.settings.reflections = method;
  request.settings.cubes.size_px = cube_px;
  return request;
}

static int mirror_add(Scene *scene, bool double_sided)
{
  Material mirror = material_plain(vec3(0.9, 0.9, 0.9), 1, 0);
  mirror.double_sided = double_sided;
  return scene_add_material(scene, mirror);
}

static double pixel_difference(const Picture *a, const Picture *b, size_t i)
{
  double most = 0;
  for (int c = 0; c < 4; c++) most = fmax(most, fabs((double)a->radiance[i][c] - (double)b->radiance[i][c]));
  return most;
}

// Does the picture show one thing there: does no neighbour within `reach` differ?
static bool is_even(const Picture *picture, size_t i, int reach)
{
  int x = (int)(i % picture->width), y = (int)(i / picture->width);
  for (int dy = -reach; dy <= reach; dy++)
    for (int dx = -reach; dx <= reach; dx++) {
      int column = x + dx, row = y + dy;
      if (column < 0 || row < 0 || column >= (int)picture->width || row >= (int)picture->height) continue;
      const float *there = picture->radiance[(size_t)row * picture->width + (size_t)column];
      // Schlick's weight changes from pixel to pixel; surfaces here differ by far more.
      for (int c = 0; c < 3; c++)
        if (fabs((double)there[c] - (double)picture->radiance[i][c]) > 0.15) return false;
    }
  return true;
}

// Pixels that differ by more than `most`, of those within which rays show one thing.
static size_t even_and_wrong(const Picture *rays, const Picture *maps, int reach, double most, size_t *even)
{
  size_t wrong = 0;
  *even = 0;
  for (size_t i = 0; i < (size_t)rays->width * rays->height; i++) {
    if (!is_even(rays, i, reach)) continue;
    ++*even;
    wrong += pixel_difference(rays, maps, i) > most;
  }
  return wrong;
}

// A room of six glowing walls of tiles, none of which is a face of a cube about the origin.
static const Vec3 room_low = {-1.9, -1.2, -2.3}, room_high = {2.4, 1.6, 1.7};

static Scene room_scene(void)
{
  enum { TILES = 4 };
  static const double colors[6][3] = {{3, 1, 1}, {1, 3, 1}, {1, 1, 3}, {3, 3, 1}, {1, 3, 3}, {3, 1, 3}};
  Scene scene = scene_empty();
  Vec3 low = room_low, size = vec3_sub(room_high, room_low);
  const Vec3 x = {size.x, 0, 0}, y = {0, size.y, 0}, z = {0, 0, size.z};
  const Vec3 walls[6][3] = {{low, y, z}, {vec3_add(low, x), z, y}, {low, z, x}, {vec3_add(low, y), x, z},
                            {low, x, y}, {vec3_add(low, z), y, x}};
  for (int i = 0; i < 6 * TILES * TILES; i++) {
    const Vec3 *wall = walls[i / (TILES * TILES)];
    const double *color = colors[i / (TILES * TILES)];
    int column = i % TILES, row = i / TILES % TILES;
    double share = (column + row) % 2 ? 0.5 : 1;
    Vec3 u = vec3_scale(wall[1], 1.0 / TILES), v = vec3_scale(wall[2], 1.0 / TILES);
    Vec3 corner = vec3_add(wall[0], vec3_add(vec3_scale(u, column), vec3_scale(v, row)));
    int glow = scene_add_material(&scene, material_glowing(vec3_scale(vec3(color[0], color[1], color[2]), share)));
    scene_add_quad(&scene, glow, corner, u, v);
  }
  return scene;
}

// ---- the environment ------------------------------------------------------------------------------------------------

// A sky as smooth as a cosine, so that its second derivative is 1 a radian squared at most.
static void sky_paint(Scene *scene)
{
  enum { WIDTH = 512, HEIGHT = 256 };
  float(*colors)[3] = calloc((size_t)WIDTH * HEIGHT, sizeof *colors);
  assert_non_null(colors);
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    double p = 2 * M_PI * ((i % WIDTH + 0.5) / WIDTH - 0.5), t = M_PI * (i / WIDTH + 0.5) / HEIGHT;
    colors[i][0] = (float)(2 + cos(p) * sin(t));
    colors[i][1] = (float)(2 + cos(t));
    colors[i][2] = (float)(2 + sin(p) * sin(t));
  }
  scene_set_image(scene, WIDTH, HEIGHT, (const float(*)[3])colors);
  free(colors);
}

static void a_mirror_in_the_sky_is_the_same_by_environment_and_by_rays(void **state)
{
  static const uint32_t widths[] = {0, 8, 1};
  Scene scene = scene_empty();
  sky_paint(&scene);
  scene_add_sphere(&scene, mirror_add(&scene, false), vec3(0, 0, 0), 1, 24);
  Camera camera = camera_perspective(vec3(1, 2, 4), vec3(0, 0, 0), 0.6);
  for (int i = 0; i < 3; i++) {
    PictureRequest by_rays = request_of(48, REFLECTIONS_RAYS, 0), by_map = request_of(48, REFLECTIONS_ENVIRONMENT, 0);
    by_rays.lanes = by_map.lanes = widths[i];
    Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
    picture_assert_signal(&rays, 0.5);
    picture_assert_same(&rays, &map);
    picture_free(&rays);
    picture_free(&map);
  }
  scene_free(&scene);
}

// Bilinear interpolation is off by s^2 / 8 times the second derivative along each of two axes; a texel of n a face is
// at most 2 / (n - 1) radians wide. The sky's image is off by as much at its own, much smaller texels.
static void a_cube_of_the_sky_is_off_by_no_more_than_interpolation(void **state)
{
  Scene scene = scene_empty();
  sky_paint(&scene);
  scene_add_sphere(&scene, mirror_add(&scene, false), vec3(0, 0, 0), 1, 24);
  Camera camera = camera_perspective(vec3(1, 2, 4), vec3(0, 0, 0), 0.6);
  for (ReflectionMethod method = REFLECTIONS_CUBE; method <= REFLECTIONS_IMPOSTOR; method += 2)
    for (uint32_t size = 16; size <= 64; size *= 2) {
      PictureRequest by_rays = request_of(48, REFLECTIONS_RAYS, 0), by_map = request_of(48, method, size);
      Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
      double texel = 2.0 / (size - 1), bound = 2 * texel * texel / 8 + 1e-4, most = 0;
      for (size_t i = 0; i < 48 * 48; i++) most = fmax(most, pixel_difference(&rays, &map, i));
      if (!(most <= bound)) fail_msg("%s, %u texels: %g, over %g", reflections_name(method), size, most, bound);
      if (!(most > 0)) fail_msg("%s: no cube was asked", reflections_name(method));
      picture_free(&rays);
      picture_free(&map);
    }
  scene_free(&scene);
}

// ---- seams ----------------------------------------------------------------------------------------------------------

static int face_of(Vec3 d)
{
  double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
  if (x >= y && x >= z) return d.x < 0;
  if (y >= z) return 2 + (d.y < 0);
  return 4 + (d.z < 0);
}

// A flat mirror of which a wide view shows several faces of a coarse cube, turned by and by: from a pixel to the next
// the map's error changes no more over an edge than within a face.
static void faces_meet_without_a_seam(void **state)
{
  enum { SIDE = 96, TURNS = 5 };
  double across = 0, within = 0;
  size_t crossed = 0;
  for (int turn = 0; turn < TURNS; turn++) {
    Scene scene = scene_empty();
    sky_paint(&scene);
    double angle = 0.3 * turn, c = cos(angle), s = sin(angle);
    const Vec3 u = {c, 0, -s}, v = {0, 1, 0}, n = {s, 0, c};
    Vec3 corner = vec3_scale(vec3_add(u, v), -30);
    scene_add_quad(&scene, mirror_add(&scene, false), corner, vec3_scale(u, 60), vec3_scale(v, 60));
    Camera camera = camera_perspective(vec3_scale(n, 2), vec3(0, 0, 0), 1.9);
    PictureRequest by_map = request_of(SIDE, REFLECTIONS_CUBE, 16), by_rays = request_of(SIDE, REFLECTIONS_RAYS, 0);
    Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
    for (size_t i = 0; i + 1 < SIDE * SIDE; i++) {
      if (i % SIDE + 1 == SIDE) continue;
      int faces[2];
      for (size_t k = 0; k < 2; k++) {
        Vec3 d = oracle_camera_ray(&camera, SIDE, SIDE, (i + k) % SIDE + 0.5, i / SIDE + 0.5).direction;
        faces[k] = face_of(vec3_sub(d, vec3_scale(n, 2 * vec3_dot(d, n))));
      }
      double jump = 0;
      for (int channel = 0; channel < 3; channel++) {
        double here = (double)map.radiance[i][channel] - (double)rays.radiance[i][channel];
        double next = (double)map.radiance[i + 1][channel] - (double)rays.radiance[i + 1][channel];
        jump = fmax(jump, fabs(next - here));
      }
      crossed += faces[0] != faces[1];
      if (faces[0] != faces[1]) across = fmax(across, jump);
      if (faces[0] == faces[1]) within = fmax(within, jump);
    }
    picture_free(&rays);
    picture_free(&map);
    scene_free(&scene);
  }
  assert_true(crossed > SIDE && within > 1e-4);
  if (!(across <= within)) fail_msg("%g across edges, %g within faces", across, within);
}

// ---- in a room ------------------------------------------------------------------------------------------------------

// A mirror ball of `radius` in the room, by a method and by rays: pixels that differ, of those that show one wall.
static void room_compare(size_t *wrong, size_t *even, ReflectionMethod method, double radius, bool double_sided,
                         Vec3 center)
{
  Scene scene = room_scene();
  scene_add_sphere(&scene, mirror_add(&scene, double_sided), center, radius, 64);
  Vec3 eye = vec3_add(center, vec3_scale(vec3(0.5, 0.4, 1), 4 * radius));
  Camera camera = camera_perspective(eye, center, 0.5);
  camera.znear_m = radius / 100;
  PictureRequest by_rays = request_of(96, REFLECTIONS_RAYS, 0), by_map = request_of(96, method, 256);
  Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
  picture_assert_signal(&rays, 0.5);
  *wrong = even_and_wrong(&rays, &map, 1, 1e-4, even);
  picture_free(&rays);
  picture_free(&map);
  scene_free(&scene);
}

// Seen from its centre everything is where the cube shows it: away from edges not a pixel differs, whether the ball's
// own inside must be passed or not.
static void a_reflector_as_small_as_a_point_is_exact(void **state)
{
  size_t wrong, even;
  for (ReflectionMethod method = REFLECTIONS_CUBE; method <= REFLECTIONS_IMPOSTOR; method++)
    for (int double_sided = 0; double_sided < 2; double_sided++) {
      room_compare(&wrong, &even, method, 1e-3, double_sided, vec3(0, 0, 0));
      if (wrong || even < 5000) fail_msg("%s: %zu of %zu pixels are wrong", reflections_name(method), wrong, even);
    }
}

// A large ball off the middle of the room: with the distances of the walls, or the box that they are, none differs;
// without, those do that show another wall.
static void the_box_and_the_impostor_know_where_the_walls_are(void **state)
{
  size_t wrong, even;
  const Vec3 center = vec3(0.7, 0.2, -0.5);
  room_compare(&wrong, &even, REFLECTIONS_BOX, 0.6, false, center);
  if (wrong || even < 5000) fail_msg("box: %zu of %zu pixels are wrong", wrong, even);
  room_compare(&wrong, &even, REFLECTIONS_IMPOSTOR, 0.6, false, center);
  if (wrong || even < 5000) fail_msg("impostor: %zu of %zu pixels are wrong", wrong, even);
  room_compare(&wrong, &even, REFLECTIONS_CUBE, 0.6, false, center);
  if (wrong < 100) fail_msg("cube: only %zu of %zu pixels are wrong", wrong, even);
}

// ---- the impostor's hit point ---------------------------------------------------------------------------------------

static bool sphere_is_hit(OracleRay ray, Vec3 center, double radius)
{
  Vec3 to = vec3_sub(center, ray.origin), d = vec3_unit_or(ray.direction, vec3(0, 0, 1));
  double along = vec3_dot(to, d);
  return along > 0 && vec3_dot(to, to) - along * along < radius * radius;
}

// A ball over a flat mirror shows where its mirror image is, behind the mirror. The cube at infinity has it elsewhere.
static void the_impostor_shows_a_ball_where_its_mirror_image_is(void **state)
{
  enum { SIDE = 128 };
  static const double radius = 0.4, margin = 0.02;  // the ball is a polyhedron: 1 - cos(pi / 2 / 48) of the radius
  const Vec3 image = vec3(0.5, -0.3, -1.2);
  Scene scene = scene_empty();
  scene_add_quad(&scene, mirror_add(&scene, false), vec3(-2, -2, 0), vec3(4, 0, 0), vec3(0, 4, 0));
  scene_add_sphere(&scene, scene_add_material(&scene, material_glowing(vec3(2, 2, 2))), vec3(0.5, -0.3, 1.2), radius,
                   48);
  Camera camera = camera_perspective(vec3(-2.5, 1, 3), vec3(0, 0, 0), 0.5);
  for (ReflectionMethod method = REFLECTIONS_CUBE; method <= REFLECTIONS_RAYS; method++) {
    PictureRequest request = request_of(SIDE, method, 128);
    Picture picture = picture_render(&scene, &camera, &request);
    size_t wrong = 0, shown = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
      OracleRay ray = oracle_camera_ray(&camera, SIDE, SIDE, i % SIDE + 0.5, i / SIDE + 0.5);
      bool inside = sphere_is_hit(ray, image, radius - margin), near = sphere_is_hit(ray, image, radius + margin);
      if (picture.radiance[i][3] == 0 || inside != near || sphere_is_hit(ray, vec3(0.5, -0.3, 1.2), radius + margin))
        continue;
      shown += inside;
      wrong += inside != (picture.radiance[i][0] > 0.5f);
    }
    assert_true(shown > 300);
    bool exact = method >= REFLECTIONS_IMPOSTOR;
    if (exact != (wrong == 0)) fail_msg("%s: %zu pixels are wrong", reflections_name(method), wrong);
    picture_free(&picture);
  }
  scene_free(&scene);
}

// ---- parallax -------------------------------------------------------------------------------------------------------

// Where a glowing thing is seen, in pixels from the top left.
static void glow_center(double at[2], const Picture *picture)
{
  double sum = 0;
  at[0] = at[1] = 0;
  for (size_t i = 0; i < (size_t)picture->width * picture->height; i++) {
    double weight = (double)picture->radiance[i][1];
    sum += weight;
    at[0] += weight * ((double)(i % picture->width) + 0.5);
    at[1] += weight * ((double)(i / picture->width) + 0.5);
  }
  if (!(sum > 50)) fail_msg("%g pixels glow", sum);
  at[0] /= sum;
  at[1] /= sum;
}

static double angle_between(Vec3 a, Vec3 b) { return atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b)); }

// A ball that comes towards a flat mirror: by rays it is seen in one direction, by the cube in another, and the angle
// between both is that of plan/cube_error.h. Far away it falls as 1 / D. A tenth of a pixel is what a centre is found
// by.
static void parallax_is_that_of_the_closed_form(void **state)
{
  enum { SIDE = 160, STEPS = 5 };
  double measured[STEPS], distance = 1.5, slack = 0.1 * 0.9 / SIDE;
  const Vec3 towards = vec3_unit_or(vec3(0.3, 0.2, 1), vec3(0, 0, 1));
  for (int i = 0; i < STEPS; i++, distance *= 2) {
    Scene scene = scene_empty();
    Vec3 target = vec3_scale(towards, distance);
    scene_add_quad(&scene, mirror_add(&scene, false), vec3(-3, -3, 0), vec3(6, 0, 0), vec3(0, 6, 0));
    scene_add_sphere(&scene, scene_add_material(&scene, material_glowing(vec3(1, 1, 1))), target, 0.08 * distance, 16);
    Camera camera = camera_perspective(vec3(-1.2, -0.8, 1.2), vec3(-0.6, -0.4, 0), 0.9);
    Vec3 directions[2], at = {0}, sight = {0};
    for (int map = 0; map < 2; map++) {
      double center[2];
      PictureRequest request = request_of(SIDE, map ? REFLECTIONS_CUBE : REFLECTIONS_RAYS, 256);
      request.settings.lighting = LIGHTING_PHONG;  // a mirror's share is the same everywhere
      request.settings.ambient = 0;
      Picture picture = picture_render(&scene, &camera, &request);
      glow_center(center, &picture);
      OracleRay ray = oracle_camera_ray(&camera, SIDE, SIDE, center[0], center[1]);
      directions[map] = ray.direction;
      if (!map) at = vec3_sub(ray.origin, vec3_scale(ray.direction, ray.origin.z / ray.direction.z));
      if (!map) sight = vec3(ray.direction.x, ray.direction.y, -ray.direction.z);
      picture_free(&picture);
    }
    measured[i] = angle_between(directions[0], directions[1]);
    double bound = cube_parallax_rad(&(CubeSight){vec3_length(at), distance, angle_between(at, sight)});
    if (!(fabs(measured[i] - bound) < slack + 0.02 * bound))
      fail_msg("%g at %g m, not %g", measured[i], distance, bound);
    assert_true(bound <= cube_parallax_most_rad(vec3_length(at), distance));
    scene_free(&scene);
  }
  double slope = log(measured[STEPS - 1] / measured[STEPS - 2]) / log(2);
  if (fabs(slope + 1) > 0.1) fail_msg("the slope is %g", slope);
}

// In the plane of incidence, two rays a small angle apart off a sphere, reflected exactly.
static void a_reflected_rays_change_is_that_of_two_rays(void **state)
{
  static const double radius = 0.5, distance = 3, step = 1e-6;
  for (double slant = 0; slant < 1.3; slant += 0.25) {
    Vec3 hit = {radius, 0, 0}, eye = vec3_add(hit, vec3(distance * cos(slant), distance * sin(slant), 0)), out[2];
    double middle = atan2(-sin(slant), -cos(slant));
    for (int i = 0; i < 2; i++) {
      Vec3 d = vec3(cos(middle + (i - 0.5) * step), sin(middle + (i - 0.5) * step), 0);
      double b = vec3_dot(eye, d), t = -b - sqrt(b * b - vec3_dot(eye, eye) + radius * radius);
      Vec3 n = vec3_scale(vec3_add(eye, vec3_scale(d, t)), 1 / radius);
      out[i] = vec3_sub(d, vec3_scale(n, 2 * vec3_dot(d, n)));
    }
    ReflectorView view = {step, distance, radius, slant, 100, 50};
    assert_true(fabs(angle_between(out[0], out[1]) / reflected_change_rad(&view) - 1) < 1e-4);
    assert_true(fabs(cube_wrong_px(&view, 0.1 * reflected_change_rad(&view)) - 10) < 1e-9);
    assert_true(cube_wrong_px(&view, 1) == 50);
  }
}

// ---- what has no map ------------------------------------------------------------------------------------------------

// Renders and tells which reflectors had maps.
static ReflectorSummary summary_of(const Scene *scene, const Camera *camera, const RenderSettings *settings)
{
  Device *device = picture_device(0);
  DeviceScene device_scene = {0};
  Frame frame = {0};
  Log log = {0};
  picture_assert_ok(device_scene_make(&device_scene, device, scene, NULL, &log));
  SceneFacts facts = {.has_mirrors = device_scene.has_mirrors, .least_roughness = device_scene.least_roughness};
  FrameRequest request = {.camera = camera,
                          .area = {settings->width, settings->height, 0, 0, settings->width, settings->height},
                          .samples = 1,
                          .plan = plan_make(settings, &facts)};
  picture_assert_ok(frame_make(&frame, device, &device_scene, &request, &log));
  ReflectorSummary summary = frame.reflectors;
  frame_free(&frame);
  device_scene_free(&device_scene);
  return summary;
}

static Scene balls_scene(int across, double radius)
{
  Scene scene = room_scene();
  int mirror = mirror_add(&scene, false);
  for (int i = 0; i < across * across; i++)
    scene_add_sphere(&scene, mirror,
                     vec3((i % across + 0.5) * 2.0 / across - 1, (i / across + 0.5) * 2.0 / across - 1, 0), radius, 4);
  return scene;
}

// A thousand reflectors: as many maps as fit into the memory allowed, the largest on screen first; the others are
// traced.
static void a_thousand_reflectors_keep_to_the_budget(void **state)
{
  Scene scene = balls_scene(32, 0.02);
  Camera camera = camera_perspective(vec3(0, 0, 1.65), vec3(0, 0, 0), 1.5);
  RenderSettings settings = request_of(256, REFLECTIONS_CUBE, 0).settings;
  settings.cubes.max_bytes = 10 * CUBE_TEXELS(32) * 16;
  ReflectorSummary summary = summary_of(&scene, &camera, &settings);
  assert_int_equal(summary.visible, 1024);
  assert_int_equal(summary.left_out, 1014);
  assert_int_equal(summary.bytes, settings.cubes.max_bytes);
  assert_int_equal(summary.least_px, 32);
  scene_free(&scene);
}

// Without memory for maps the picture is that of rays.
static void what_has_no_map_is_traced(void **state)
{
  Scene scene = balls_scene(2, 0.4);
  Camera camera = camera_perspective(vec3(0.3, 0, 1.65), vec3(0, 0, 0), 1.5);
  PictureRequest by_rays = request_of(64, REFLECTIONS_RAYS, 0), by_map = request_of(64, REFLECTIONS_CUBE, 64);
  by_rays.settings.max_depth = by_map.settings.max_depth = 1;
  Picture rays = picture_render(&scene, &camera, &by_rays), some, none;
  by_map.settings.cubes.max_bytes = 1;
  none = picture_render(&scene, &camera, &by_map);
  picture_assert_same(&rays, &none);
  by_map.settings.cubes.max_bytes = CUBE_TEXELS(64) * 16;  // of four
  some = picture_render(&scene, &camera, &by_map);
  size_t different = 0;
  for (size_t i = 0; i < 64 * 64; i++) different += pixel_difference(&rays, &some, i) > 0;
  if (different < 20 || different > 64 * 64 / 3) fail_msg("%zu pixels differ", different);
  picture_free(&rays);
  picture_free(&none);
  picture_free(&some);
  scene_free(&scene);
}

// The camera at the centre of a reflector, a reflector within another, one without area, one at which nobody looks, a
// scene in which all is a mirror: pictures come out, of numbers.
static void odd_reflectors_make_pictures(void **state)
{
  for (ReflectionMethod method = REFLECTIONS_ENVIRONMENT; method <= REFLECTIONS_IMPOSTOR; method++)
    for (int i = 0; i < 5; i++) {
      Scene scene = i == 4 ? scene_empty() : room_scene();
      int mirror = mirror_add(&scene, true);
      if (i == 0 || i == 1) scene_add_sphere(&scene, mirror, vec3(0, 0, 0), 0.5, 8);
      if (i == 1) scene_add_sphere(&scene, mirror, vec3(0, 0, 0), 0.25, 8);
      if (i == 2) scene_add_quad(&scene, mirror, vec3(-1, 0, 0), vec3(2, 0, 0), vec3(0, 0, 0));
      if (i == 3) scene_add_quad(&scene, mirror, vec3(-1, -1, 1.5), vec3(2, 0, 0), vec3(0, 2, 0));
      if (i == 4) scene_add_box(&scene, mirror, vec3(-1, -1, -1), vec3(1, 1, 1));
      Camera camera = camera_perspective(vec3(0, 0, i == 2 ? 1.5 : 0), vec3(0, 0.1, -1), 1);
      camera.znear_m = 1e-3;
      PictureRequest request = request_of(32, method, 16);
      Picture picture = picture_render(&scene, &camera, &request);
      for (size_t k = 0; k < 32 * 32; k++)
        for (int c = 0; c < 4; c++) assert_true(isfinite(picture.radiance[k][c]) && picture.radiance[k][c] >= 0);
      picture_free(&picture);
      scene_free(&scene);
    }
}

// With rays first and nothing deeper, one reflection is all there is.
static void deeper_bounces_may_be_left_out(void **state)
{
  Scene scene = balls_scene(2, 0.4);
  Camera camera = camera_perspective(vec3(0.3, 0, 1.65), vec3(0, 0, 0), 1.5);
  PictureRequest once = request_of(64, REFLECTIONS_RAYS, 0), all = once, deep = once;
  once.settings.max_depth = 1;
  deep.settings.deep_reflections = REFLECTIONS_NONE;
  Picture by_depth = picture_render(&scene, &camera, &once), by_method = picture_render(&scene, &camera, &deep);
  Picture whole = picture_render(&scene, &camera, &all);
  picture_assert_same(&by_depth, &by_method);
  // The first bounce by rays, deeper ones by maps: no closer to the first alone than to all of them.
  deep.settings.deep_reflections = REFLECTIONS_IMPOSTOR;
  Picture mixed = picture_render(&scene, &camera, &deep);
  double from_once = 0, from_all = 0;
  for (size_t i = 0; i < 64 * 64; i++) {
    from_once += pixel_difference(&mixed, &by_depth, i);
    from_all += pixel_difference(&mixed, &whole, i);
  }
  if (!(from_all < 0.25 * from_once && from_all > 0)) fail_msg("%g from all, %g from one", from_all, from_once);
  picture_free(&by_depth);
  picture_free(&by_method);
  picture_free(&whole);
  picture_free(&mixed);
  scene_free(&scene);
}

// ---- always the same ------------------------------------------------------------------------------------------------

// However many rays are in flight, and on every run.
static void the_bytes_do_not_hang_on_the_waves(void **state)
{
  Scene scene = balls_scene(3, 0.25);
  scene_add_light(&scene, light_point(vec3(0, 1, 1), 10));
  Camera camera = camera_perspective(vec3(0.3, 0, 1.65), vec3(0, 0, 0), 1.5);
  PictureRequest request = request_of(64, REFLECTIONS_IMPOSTOR, 64);
  Picture whole = picture_render(&scene, &camera, &request), again = picture_render(&scene, &camera, &request);
  request.wave_rays = 2048;
  Picture parts = picture_render(&scene, &camera, &request);
  picture_assert_same(&whole, &again);
  picture_assert_same(&whole, &parts);
  picture_free(&whole);
  picture_free(&again);
  picture_free(&parts);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_mirror_in_the_sky_is_the_same_by_environment_and_by_rays),
      cmocka_unit_test(a_cube_of_the_sky_is_off_by_no_more_than_interpolation),
      cmocka_unit_test(faces_meet_without_a_seam),
      cmocka_unit_test(a_reflector_as_small_as_a_point_is_exact),
      cmocka_unit_test(the_box_and_the_impostor_know_where_the_walls_are),
      cmocka_unit_test(the_impostor_shows_a_ball_where_its_mirror_image_is),
      cmocka_unit_test(parallax_is_that_of_the_closed_form),
      cmocka_unit_test(a_reflected_rays_change_is_that_of_two_rays),
      cmocka_unit_test(a_thousand_reflectors_keep_to_the_budget),
      cmocka_unit_test(what_has_no_map_is_traced),
      cmocka_unit_test(deeper_bounces_may_be_left_out),
      cmocka_unit_test(odd_reflectors_make_pictures),
      cmocka_unit_test(the_bytes_do_not_hang_on_the_waves),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

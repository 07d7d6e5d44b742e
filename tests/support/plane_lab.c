#include "support/plane_lab.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/oracle_environment.h"

double plane_component(Vec3 v, int channel) { return channel == 0 ? v.x : channel == 1 ? v.y : v.z; }

Mean mean_of(const Picture *picture, uint32_t x, uint32_t y, uint32_t width, uint32_t height, int channel)
{
  double sum = 0, squares = 0, count = (double)width * height;
  for (uint32_t i = 0; i < width * height; i++) {
    double value = picture_pixel(picture, x + i % width, y + i / width)[channel];
    sum += value;
    squares += value * value;
  }
  double mean = sum / count, variance = fmax(squares / count - mean * mean, 0);
  return (Mean){mean, sqrt(variance / (count - 1))};
}

void mean_check(Mean got, double wanted, double oracle_error, const char *what)
{
  if (!(fabs(got.value - wanted) <= 4.5 * got.error + oracle_error * wanted))
    fail_msg("%s: %.6f +- %.6f, not %.6f", what, got.value, got.error, wanted);
}

static const Vec3 ball_center = {1.1, 1.2, 0.4};
static const double ball_radius = 0.9, view_cosine = 0.6;

void plane_set_image(Scene *scene)
{
  enum { WIDTH = 32, HEIGHT = 16 };
  float colors[WIDTH * HEIGHT][3];
  for (int i = 0; i < WIDTH * HEIGHT; i++)
    for (int c = 0; c < 3; c++) colors[i][c] = (float)(0.7 + 0.6 * sin(0.9 * (i % WIDTH) + c) * cos(0.5 * (i / WIDTH)));
  for (int c = 0; c < 3; c++) colors[4 * WIDTH + 9][c] = 300;  // 45 degrees high, not behind the ball
  scene_set_image(scene, WIDTH, HEIGHT, (const float(*)[3])colors);
  scene->environment.rotation_rad = 0.7;
  scene->environment.intensity = 1.5f;
}

Scene plane_scene(Material material)
{
  Scene scene = scene_empty();
  scene_add_quad(&scene, scene_add_material(&scene, material), vec3(-0.01, 0, 0.01), vec3(0.02, 0, 0),
                 vec3(0, 0, -0.02));
  return scene;
}

Material plane_black_unlit(void)
{
  Material material = material_plain(vec3(0, 0, 0), 0, 1);
  material.unlit = true;
  return material;
}

void plane_add_cover(Scene *scene, Cover cover, Material material)
{
  if (cover == COVER_NONE) return;
  int at = scene_add_material(scene, material);
  if (cover == COVER_BALL) scene_add_sphere(scene, at, ball_center, ball_radius, 96);
  if (cover == COVER_SHEET)
    scene_add_quad(scene, at, vec3(-1e4, 1, 1e4), vec3(2e4, 0, 0), vec3(0, 0, -2e4));  // faces up
}

static Vec3 plane_view(void)
{
  double sine = sqrt(1 - view_cosine * view_cosine);
  return vec3(sine * cos(2.5), view_cosine, sine * sin(2.5));
}

static bool ball_blocks(Vec3 direction)
{
  double along = vec3_dot(ball_center, direction), across2 = vec3_dot(ball_center, ball_center) - along * along;
  return along > 0 && across2 < ball_radius * ball_radius;
}

Vec3 plane_lobes_integral(const Environment *environment, const OracleSurface *surface, Cover cover, bool diffuse)
{
  enum { ROWS = 640, COLUMNS = 1280 };
  Vec3 sum = {0}, n = vec3(0, 1, 0), view = plane_view();
  for (int i = 0; i < ROWS * COLUMNS; i++) {
    double y = (i / COLUMNS + 0.5) / ROWS, phi = 2 * M_PI * (i % COLUMNS + 0.5) / COLUMNS, ring = sqrt(1 - y * y);
    Vec3 l = vec3(ring * cos(phi), y, ring * sin(phi));
    if (cover == COVER_BALL && ball_blocks(l)) continue;
    OracleBrdf f = oracle_brdf(ORACLE_PBR, surface, n, view, l);
    Vec3 sends = vec3_mul(diffuse ? vec3_add(f.diffuse, f.specular) : f.specular, oracle_environment(environment, l));
    sum = vec3_add(sum, vec3_scale(sends, y * 2 * M_PI / (ROWS * COLUMNS)));
  }
  return sum;
}

Vec3 plane_integral(const Environment *environment, const OracleSurface *surface, Cover cover)
{
  return plane_lobes_integral(environment, surface, cover, true);
}

Picture plane_picture(const Scene *scene, const PictureRequest *request)
{
  Camera camera = camera_orthographic(vec3_scale(plane_view(), 0.5), vec3(0, 0, 0), 1e-4);
  return picture_render(scene, &camera, request);
}

void plane_check(const Scene *scene, const PictureRequest *request, Vec3 wanted, const char *what)
{
  Picture picture = plane_picture(scene, request);
  for (int c = 0; c < 3; c++) {
    Mean got = mean_of(&picture, 0, 0, PATCH, PATCH, c);
    if (c == 1)
      print_message("%s, LANES %u: %.5f +- %.5f for %.5f\n", what, request->lanes, got.value, got.error,
                    plane_component(wanted, c));
    mean_check(got, plane_component(wanted, c), 1e-3, what);
  }
  picture_free(&picture);
}

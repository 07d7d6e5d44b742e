// Lights with methods of their own: each light's part of a picture is what it is by that method alone.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "app/light_shadows.h"
#include "scene/scene_build.h"
#include "support/picture_fixture.h"

enum { WIDTH = 64, HEIGHT = 40, PIXELS = WIDTH * HEIGHT, LIGHTS = 7 };

// Boxes, a ball and open sheets on a floor, and a mirror behind them; more lights than a launch shades at once.
static Scene scene_lit(void)
{
  Scene scene = scene_empty();
  int grey = scene_add_material(&scene, material_plain(vec3(0.7, 0.7, 0.7), 0, 1));
  int mirror = scene_add_material(&scene, material_plain(vec3(0.9, 0.9, 0.9), 1, 0));
  scene_add_quad(&scene, grey, vec3(-6, 0, 6), vec3(12, 0, 0), vec3(0, 0, -12));
  scene_add_quad(&scene, mirror, vec3(-3, 0, -3.5), vec3(6, 0, 0), vec3(0, 2, 0));
  scene_add_sphere(&scene, grey, vec3(0.5, 0.6, 1.2), 0.6, 10);
  for (int i = 0; i < 4; i++) {
    scene_add_box(&scene, grey, vec3(-4 + 2 * i, 0, -2), vec3(-3.2 + 2 * i, 0.6 + 0.3 * i, -1.4));
    scene_add_quad(&scene, grey, vec3(-3 + 1.7 * i, 1.3, 1), vec3(0.9, 0.2 * i - 0.3, 0.2), vec3(0.1, 0.5, 0.4));
  }
  scene_add_light(&scene, light_point(vec3(0.3, 3.1, 0.2), 20));
  scene_add_light(&scene, light_spot(vec3(3, 5, 4), vec3(0, 0, 0), 120, 0.3, 0.5));
  scene_add_light(&scene, light_directional(vec3(-0.4, -1, -0.3), 1));
  scene_add_light(&scene, light_point(vec3(-3, 2.5, 3), 15));
  scene_add_light(&scene, light_directional(vec3(0.7, -1, 0.2), 0.7));
  scene_add_light(&scene, light_point(vec3(0.2, 1.3, 1.2), 4));  // within its radius there is part of the ball
  scene_add_light(&scene, light_spot(vec3(-4, 4, -1), vec3(0, 0, 0), 60, 0.2, 0.4));
  return scene;
}

static PictureRequest request_of(const uint8_t *methods)
{
  PictureRequest request = picture_request(WIDTH, HEIGHT, 2);
  request.settings.light_shadows = methods;
  request.settings.shadow_options =
      (ShadowOptions){.map_size_px = 64, .kernel_px = 3, .light_radius_m = 0.4f, .light_angle_rad = 0.03};
  return request;
}

static bool is_lit(const uint8_t *methods, uint32_t light) { return methods[light] != SHADOWS_AUTO; }

// A picture with light by those lights alone that `methods` gives one (here AUTO stands for none).
static Picture render(Scene *scene, const uint8_t *methods, const PictureRequest *request)
{
  float intensities[LIGHTS];
  Camera camera = camera_perspective(vec3(1, 4, 8), vec3(0, 0.5, 0), 0.75);
  for (uint32_t i = 0; i < LIGHTS; i++) {
    intensities[i] = scene->lights[i].intensity;
    if (!is_lit(methods, i)) scene->lights[i].intensity = 0;
  }
  Picture picture = picture_render(scene, &camera, request);
  for (uint32_t i = 0; i < LIGHTS; i++) scene->lights[i].intensity = intensities[i];
  return picture;
}

static Picture render_mixed(Scene *scene, const uint8_t *methods)
{
  const PictureRequest request = request_of(methods);
  return render(scene, methods, &request);
}

// Adds what one light brings by one method, as a picture of it alone has it.
static void light_add(double (*sum)[3], Scene *scene, const uint8_t *methods, uint32_t light)
{
  uint8_t alone[LIGHTS];
  PictureRequest request = request_of(NULL);
  request.settings.shadows = (ShadowMethod)methods[light];
  memset(alone, SHADOWS_AUTO, sizeof alone);
  alone[light] = methods[light];
  Picture picture = render(scene, alone, &request);
  for (uint32_t i = 0; i < PIXELS; i++)
    for (int c = 0; c < 3; c++) sum[i][c] += (double)picture.radiance[i][c];
  picture_free(&picture);
}

static void adds_up(Scene *scene, const uint8_t *methods)
{
  double sum[PIXELS][3] = {{0}};
  for (uint32_t i = 0; i < LIGHTS; i++)
    if (is_lit(methods, i)) light_add(sum, scene, methods, i);
  Picture mixed = render_mixed(scene, methods);
  picture_assert_signal(&mixed, 0.05);
  for (uint32_t i = 0; i < PIXELS; i++)
    for (int c = 0; c < 3; c++) {
      double is = (double)mixed.radiance[i][c];
      if (fabs(is - sum[i][c]) > 3e-6 * (1 + sum[i][c]))
        fail_msg("methods %d%d%d%d%d%d%d, pixel (%u, %u): %g, lights alone %g", methods[0], methods[1], methods[2],
                 methods[3], methods[4], methods[5], methods[6], i % WIDTH, i / WIDTH, is, sum[i][c]);
    }
  picture_free(&mixed);
}

#define OFF SHADOWS_AUTO
static const uint8_t mixes[][LIGHTS] = {
    {OFF, SHADOWS_RAYS, OFF, SHADOWS_NONE, SHADOWS_MAP, OFF, OFF},
    {OFF, OFF, SHADOWS_PCSS, SHADOWS_MAP, OFF, SHADOWS_PCF, OFF},
    {SHADOWS_HYBRID, SHADOWS_NONE, SHADOWS_RAYS, SHADOWS_PCSS, SHADOWS_HYBRID, SHADOWS_AREA, SHADOWS_HYBRID},
};

static void lights_add_up_whatever_their_methods(void **state)
{
  Scene scene = scene_lit();
  for (size_t i = 0; i < sizeof mixes / sizeof *mixes; i++) adds_up(&scene, mixes[i]);
  scene_free(&scene);
}

// The bytes, too: sums keep their order whatever judges a light's rays.
static void hybrid_lights_are_traced_ones_among_all_others(void **state)
{
  const uint8_t *mixed = mixes[sizeof mixes / sizeof *mixes - 1];
  uint8_t traced[LIGHTS];
  Scene scene = scene_lit();
  for (uint32_t i = 0; i < LIGHTS; i++) traced[i] = mixed[i] == SHADOWS_HYBRID ? SHADOWS_RAYS : mixed[i];
  Picture a = render_mixed(&scene, mixed), b = render_mixed(&scene, traced);
  assert_true(a.shadow_rays > 2000 && a.shadow_rays_traced * 2 < a.shadow_rays && b.shadow_rays == 0);
  picture_assert_same(&a, &b);
  picture_free(&a);
  picture_free(&b);
  scene_free(&scene);
}

// ---- names ----------------------------------------------------------------------------------------------------------

static Scene scene_named(void)
{
  static const char *const names[] = {"Sun", "Lamp, left", "Lamp", "Lamp", "", "a=map,b", "#2"};
  Scene scene = scene_empty();
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    scene_add_light(&scene, light_point(vec3(0, 1, 0), 1));
    free(scene.lights[i].name);
    scene.lights[i].name = strdup(names[i]);
  }
  return scene;
}

static Status resolve(uint8_t **out, const char *text)
{
  Scene scene = scene_named();
  Option option = render_command_line.options[0];
  RenderOptions options = {.settings.shadows = SHADOWS_RAYS};
  for (size_t i = 0; i < render_command_line.option_count; i++)
    if (render_command_line.options[i].read == option_read_light_shadows) option = render_command_line.options[i];
  picture_log = (Log){0};
  Status status = option_read_light_shadows(&options.light_shadows, &option, text, &picture_log);
  *out = NULL;
  if (!status) status = light_shadows_resolve(out, &options, &scene, &picture_log);
  scene_free(&scene);
  return status;
}

// `expected`: the method of each light by its number.
static void names_mean(const char *text, const char *expected)
{
  uint8_t *methods;
  Status status = resolve(&methods, text);
  if (status) fail_msg("%s: %s", text, picture_log.error);
  for (uint32_t i = 0; i < LIGHTS; i++)
    if (methods[i] != (uint8_t)(expected[i] - '0')) fail_msg("%s: light %u gets %d", text, i + 1, methods[i]);
  free(methods);
}

static void refused(const char *text, const char *message)
{
  uint8_t *methods;
  if (resolve(&methods, text) != STATUS_USAGE || !strstr(picture_log.error, message))
    fail_msg("'%s' gives %s; expected: %s", text, picture_log.error, message);
}

static void lights_are_named_or_numbered(void **state)
{
  names_mean("Sun=pcf", "2555555");
  names_mean("Lamp=none", "5500555");  // all of that name
  names_mean("Lamp=none,#4=map", "5501555");
  names_mean("#4=map,Lamp=none", "5500555");  // the last counts
  names_mean("Lamp, left=area,Sun=hybrid", "4655555");
  names_mean("#5=pcss", "5555355");
  names_mean("#2=pcss", "5355555");  // a number, whatever a light is called
  names_mean("#7=pcss,Sun=auto", "7555553");
  refused("Lampe=pcf",
          "--light-shadows: no light is called 'Lampe': lights are: #1 'Sun', #2 'Lamp, left', #3 'Lamp', #4 'Lamp', ");
  refused("Sun=pcf,#8=pcf", "no light is called '#8'");
  refused("#0=pcf", "no light is called '#0'");
  refused("sun=pcf", "no light is called 'sun'");
  refused("Sun=soft", "--light-shadows soft: no such value: did you mean ");
  refused("Sun=pcf,Lamp=ray", "--light-shadows ray: no such value: did you mean 'rays'?");
  refused("Sun", "--light-shadows Sun: not valid: expected NAME=METHOD,NAME=METHOD,...");
  refused("Sun=", "not valid: expected NAME=METHOD");
  refused("", "not valid: expected NAME=METHOD");
  refused("=pcf", "not valid: expected NAME=METHOD");
  refused("Sun=pcf,", "not valid: expected");
  refused("Sun=pcf,,Lamp=map", "no light is called ',Lamp'");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(lights_add_up_whatever_their_methods),
      cmocka_unit_test(hybrid_lights_are_traced_ones_among_all_others),
      cmocka_unit_test(lights_are_named_or_numbered),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

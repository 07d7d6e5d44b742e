#include "support/mirrors.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

#include "scene/scene_build.h"

PictureRequest mirrors_request(uint32_t side, ReflectionMethod method, uint32_t cube_px)
{
  PictureRequest request = picture_request(side, side, 1);
  request.settings.reflections = method;
  request.settings.cubes.size_px = cube_px;
  return request;
}

int mirrors_material(Scene *scene, bool double_sided)
{
  Material mirror = material_plain(vec3(0.9, 0.9, 0.9), 1, 0);
  mirror.double_sided = double_sided;
  return scene_add_material(scene, mirror);
}

void mirrors_sky(Scene *scene)
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

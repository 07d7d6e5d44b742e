// glTF import on real files: the shared models, held to the triangle counts of their README.
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/gltf_build.h"

// The file of a row: `open X` in the row, else Name/Name.glb or .gltf; false where there is none.
static bool file_of_row(char path[512], const char *assets, const char *name, const char *row)
{
  const char *named = strstr(row, "open `");
  if (named) {
    snprintf(path, 512, "%s/%s/%.*s", assets, name, (int)strcspn(named + 6, "`"), named + 6);
    return access(path, R_OK) == 0;
  }
  snprintf(path, 512, "%s/%s/%s.glb", assets, name, name);
  if (access(path, R_OK) != 0) snprintf(path, 512, "%s/%s/%s.gltf", assets, name, name);
  return access(path, R_OK) == 0;
}

// The last number of a cell such as "154,154 / 743,096".
static uint64_t drawn_count(const char *cell, const char *end)
{
  uint64_t count = 0;
  for (; cell < end; cell++) {
    if (*cell == '/') count = 0;
    if (*cell >= '0' && *cell <= '9') count = 10 * count + (uint64_t)(*cell - '0');
  }
  return count;
}

static void check_row(const char *path, uint64_t triangles, const char *row)
{
  if (strstr(row, "draco") || strstr(row, "meshopt")) {
    const char *name = strstr(row, "draco") ? "KHR_draco_mesh_compression" : "EXT_meshopt_compression";
    gltf_read_fails(path, STATUS_UNSUPPORTED, name);
    return;
  }
  Scene scene = gltf_read_fine(path);
  if (scene_triangle_count(&scene) != triangles)
    fail_msg("%s: %llu triangles, not %llu", path, (unsigned long long)scene_triangle_count(&scene),
             (unsigned long long)triangles);
  for (uint32_t i = 0; i < scene.image_count; i++) assert_true(scene.images[i].texels && scene.images[i].width > 0);
  scene_free(&scene);
}

static void every_model_draws_the_triangles_its_readme_says(void **state)
{
  const char *assets = gltf_assets();
  char path[512], row[4096];
  int models = 0;
  if (!assets) return;
  snprintf(path, sizeof path, "%s/README.md", assets);
  FILE *readme = fopen(path, "r");
  assert_non_null(readme);
  while (fgets(row, sizeof row, readme)) {
    char *cells[8], name[64];
    int count = 0;
    for (char *at = row; (at = strchr(at, '|')) && count < 8; at++) cells[count++] = at;
    if (count != 7 || sscanf(cells[0], "| %63s", name) != 1 || !file_of_row(path, assets, name, row)) continue;
    models++;
    check_row(path, drawn_count(cells[4], cells[5]), row);
  }
  fclose(readme);
  if (models < 48) fail_msg("only %d models were found in the README", models);
}

static void hall_has_its_cameras_and_lights(void **state)
{
  const char *assets = gltf_assets();
  char path[512];
  if (!assets) return;
  snprintf(path, sizeof path, "%s/Hall/Hall.glb", assets);
  Scene scene = gltf_read_fine(path);
  assert_int_equal(scene.object_count, 171);
  assert_int_equal(scene.mesh_count, 32);
  assert_int_equal(scene.camera_count, 2);
  assert_string_equal(scene.cameras[0].name, "camera_nave");
  assert_int_equal(scene.light_count, 4);
  assert_string_equal(gltf_warnings, "");
  for (uint32_t i = 0; i < scene.light_count; i++)
    if (scene.lights[i].kind == LIGHT_SPOT) assert_near(scene.lights[i].intensity, 220);
  scene_free(&scene);
}

// The fox is stored in parts bound to joints: only a skin that is applied puts its lowest point on the floor.
static void fox_stands_on_its_feet(void **state)
{
  const char *assets = gltf_assets();
  char path[512];
  Vec3 low, high;
  if (!assets) return;
  snprintf(path, sizeof path, "%s/Fox/Fox.glb", assets);
  Scene scene = gltf_read_fine(path);
  assert_true(scene_bounds(&scene, &low, &high));
  assert_true(low.y > -1 && low.y < 1 && high.y > 70 && high.y < 90 && high.z - low.z > 140);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_model_draws_the_triangles_its_readme_says),
      cmocka_unit_test(hall_has_its_cameras_and_lights),
      cmocka_unit_test(fox_stands_on_its_feet),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}

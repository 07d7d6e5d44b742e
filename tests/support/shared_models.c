#include "support/shared_models.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "support/gltf_build.h"

// The model in a folder of the assets: its .glb or .gltf.
static bool model_in_folder(char path[1024], const char *assets, const char *folder)
{
  bool found = false;
  snprintf(path, 1024, "%s/%s", assets, folder);
  DIR *directory = opendir(path);
  if (!directory) return false;
  for (struct dirent *entry; (entry = readdir(directory));) {
    const char *ending = strrchr(entry->d_name, '.');
    if (!ending || (strcmp(ending, ".glb") && strcmp(ending, ".gltf"))) continue;
    snprintf(path, 1024, "%s/%s/%s", assets, folder, entry->d_name);
    found = true;
  }
  closedir(directory);
  return found;
}

uint32_t shared_models_visit(ModelVisit visit, void *context)
{
  const char *assets = gltf_assets();
  char path[1024];
  uint32_t models = 0;
  if (!assets) skip();
  DIR *directory = opendir(assets);
  assert_non_null(directory);
  for (struct dirent *entry; (entry = readdir(directory));) {
    if (entry->d_name[0] == '.' || !model_in_folder(path, assets, entry->d_name)) continue;
    if (strstr(path, "Draco") || strstr(path, "Meshopt")) continue;  // compressed, which the import refuses
    Scene scene = gltf_read_fine(path);
    visit(context, path, &scene);
    models++;
    scene_free(&scene);
  }
  closedir(directory);
  return models;
}

#include "scene/gltf.h"

#include <stdlib.h>
#include <string.h>

#include "scene/gltf_context.h"
#include "scene/gltf_guard.h"
#include "scene/gltf_materials.h"
#include "scene/gltf_nodes.h"
#include "scene/gltf_shim.h"

Status gltf_read(Scene *out, const char *path, const GltfOptions *options, ImageHelper *images, Log *log)
{
  Status status = STATUS_OK;
  Gltf gltf = {.path = path, .options = options, .images_helper = images, .log = log};
  Scene scene = {0};
  char *json = NULL;
  TRY(gltf_guard(&json, &gltf));
  TRY(gltf_shim_load(&gltf.model, json, strlen(json), path, log));
  if (gltf.model->animation_count > 0)
    log_warn(log, "%s: %u animations: the pose at rest is drawn", path, gltf.model->animation_count);
  TRY(gltf_copy_name(&scene.path, &gltf, path));
  TRY(gltf_nodes_read(&scene, &gltf));
  TRY(gltf_materials_read(&scene, &gltf));
  *out = scene;
  scene = (Scene){0};

done:
  free(json);
  scene_free(&scene);
  gltf_close(&gltf);
  return status;
}

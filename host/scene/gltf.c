#include "scene/gltf.h"

#include "scene/gltf_materials.h"
#include "scene/gltf_nodes.h"

Status gltf_scene_read(Scene *out, GltfPlaces *places, Gltf *gltf)
{
  Status status = STATUS_OK;
  Scene scene = {0};
  TRY(gltf_copy_name(&scene.path, gltf, gltf->path));
  TRY(gltf_nodes_read(&scene, places, gltf));
  TRY(gltf_materials_read(&scene, gltf));
  *out = scene;
  scene = (Scene){0};

done:
  scene_free(&scene);
  return status;
}

Status gltf_read(Scene *out, const char *path, const GltfOptions *options, ImageHelper *images, Log *log)
{
  Status status = STATUS_OK;
  Gltf gltf = {.path = path, .options = options, .images_helper = images, .log = log};
  GltfPlaces places = {0};
  TRY(gltf_open(&gltf));
  if (gltf.model->animation_count > 0)
    log_warn(log, "%s: %u animations: the pose at rest is drawn: add --frames to see them move", path,
             gltf.model->animation_count);
  TRY(gltf_scene_read(out, &places, &gltf));

done:
  gltf_places_free(&places);
  gltf_close(&gltf);
  return status;
}

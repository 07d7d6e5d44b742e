#include "device_scene/flat_scene.h"

#include <stdlib.h>

Status flat_scene_make(FlatScene *out, const Scene *scene, Log *log)
{
  Status status = STATUS_OK;
  FlatScene flat = {0};
  TRY(flat_geometry_make(&flat, scene, log));
  TRY(flat_materials_make(&flat, scene, log));
  flat_environment_make(&flat, &scene->environment);
  *out = flat;
  flat = (FlatScene){0};

done:
  flat_scene_free(&flat);
  return status;
}

void flat_scene_forget(FlatScene *flat)
{
  flat->positions = flat->normals = NULL;
  flat->tangents = flat->colors = NULL;
  flat->uvs = NULL;
  flat->corners = NULL;
  flat->texels = NULL;
}

void flat_scene_free(FlatScene *flat)
{
  free(flat->positions);
  free(flat->normals);
  free(flat->tangents);
  free(flat->uvs);
  free(flat->colors);
  free(flat->corners);
  free(flat->flags);
  free(flat->object_starts);
  free(flat->materials);
  free(flat->textures);
  free(flat->texels);
  free(flat->lights);
  *flat = (FlatScene){0};
}

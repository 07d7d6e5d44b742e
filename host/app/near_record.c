#include "app/near_record.h"

#include "app/app.h"

static json_t *name_json(const Scene *scene, uint32_t object)
{
  return app_json_text(scene->objects[object].name ? scene->objects[object].name : "");
}

static json_t *target_json(const Scene *scene, const NearObject *near)
{
  json_t *target =
      json_pack("{s:i, s:o, s:i, s:s}", "object", (int)near->object, "name", name_json(scene, near->object),
                "triangles", (int)near->triangles, "method", near_method_name(near->method));
  if (target && near->reason != NEAR_AS_ASKED)
    json_object_set_new(target, "reason", json_string(near_reason_name(near->reason)));
  return target;
}

json_t *near_objects_json(const Frame *frame)
{
  const NearObjects *near = &frame->near_objects;
  const NearReflect *rays = &frame->near_reflect;
  const Scene *scene = frame->scene->source;
  json_t *reflectors = json_array();
  for (uint32_t i = 0; i < near->cube_count; i++) {
    const NearList *list = &near->lists[i];
    json_t *targets = json_array();
    for (uint32_t k = 0; k < list->count; k++) json_array_append_new(targets, target_json(scene, &list->objects[k]));
    json_array_append_new(reflectors, json_pack("{s:i, s:o, s:i, s:o}", "object", (int)near->reflectors[i], "name",
                                                name_json(scene, near->reflectors[i]), "left_out", (int)list->left_out,
                                                "targets", targets));
  }
  return json_pack("{s:o, s:i, s:I, s:I, s:I, s:I}", "reflectors", reflectors, "snapshots", (int)near->snapshot_count,
                   "bytes", (json_int_t)near->bytes, "listed", (json_int_t)rays->totals[NEAR_LISTED], "failed_cube",
                   (json_int_t)rays->totals[NEAR_FAILED_CUBE], "failed_snapshot",
                   (json_int_t)rays->totals[NEAR_FAILED_SNAPSHOT]);
}

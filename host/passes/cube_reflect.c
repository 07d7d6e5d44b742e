#include "passes/cube_reflect.h"

#include "passes/scene_args.h"

Status cube_reflect_make(CubeReflect *out, Device *device, const DeviceScene *scene, const CubeTable *table,
                         bool marched, Log *log)
{
  Status status = STATUS_OK;
  CubeReflect reflect = {.cube_count = table->count};
  Program *program = NULL;
  const size_t of_object_bytes = scene->object_count * sizeof *table->of_object;
  size_t texels = 0;
  for (uint32_t i = 0; i < table->count; i++) texels += CUBE_TEXELS((size_t)table->cubes[i].size);
  TRY(program_build(&program, device, "capture/cube_reflect.cl", "", log));
  TRY(program_kernel(&reflect.kernel, program, "cube_reflect", log));
  TRY(buffer_create(&reflect.cubes, device, table->count * sizeof *table->cubes, table->cubes, "cube maps", log));
  TRY(buffer_create(&reflect.cube_of_object, device, of_object_bytes, table->of_object, "cube maps", log));
  TRY(buffer_create(&reflect.deep_of_object, device, of_object_bytes, table->deep_of_object, "cube maps", log));
  TRY(buffer_create(&reflect.texels, device, texels * sizeof(Float4), NULL, "cube maps", log));
  TRY(buffer_zero(device, &reflect.texels, log));
  TRY(buffer_create(&reflect.hull, device, marched ? texels * sizeof(float) : 0, NULL, "cube maps", log));
  TRY(buffer_create(&reflect.cells, device, marched ? texels / (CUBE_CELL * CUBE_CELL) * sizeof(float) : 0, NULL,
                    "cube maps", log));
  TRY(buffer_create(&reflect.levels, device, table->level_texels * sizeof(Float4), NULL, "cube map levels", log));
  TRY(buffer_create(&reflect.count, device, sizeof(uint32_t), NULL, "cube maps", log));
  *out = reflect;
  reflect = (CubeReflect){0};

done:
  cube_reflect_free(&reflect);
  return status;
}

void cube_reflect_free(CubeReflect *reflect)
{
  kernel_free(&reflect->kernel);
  buffer_free(&reflect->cubes);
  buffer_free(&reflect->cube_of_object);
  buffer_free(&reflect->deep_of_object);
  buffer_free(&reflect->texels);
  buffer_free(&reflect->hull);
  buffer_free(&reflect->cells);
  buffer_free(&reflect->levels);
  buffer_free(&reflect->count);
  *reflect = (CubeReflect){0};
}

static uint32_t map_of(ReflectionMethod method)
{
  switch (method) {
    case REFLECTIONS_CUBE: return REFLECT_BY_CUBE;
    case REFLECTIONS_BOX: return REFLECT_BY_BOX;
    case REFLECTIONS_IMPOSTOR: return REFLECT_BY_IMPOSTOR;
    case REFLECTIONS_SNAPSHOT:
    case REFLECTIONS_CANDIDATES:
    case REFLECTIONS_MIXED: return REFLECT_BY_IMPOSTOR;
    default: return REFLECT_BY_ENVIRONMENT;
  }
}

Status cube_reflect(CubeReflect *reflect, Device *device, const DeviceScene *scene, ReflectionMethod method,
                    CubeAsk ask, const RayStream *rays, uint32_t count, const DeviceBuffer *radiance,
                    const RayStream *left, uint32_t *left_count, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t map = map_of(method), rough_alone = reflections_use_lists(method), closed = ask == ASK_CLOSED;
  const DeviceBuffer *of_object = ask == ASK_FIRST ? &reflect->cube_of_object : &reflect->deep_of_object;
  TRY(buffer_zero(device, &reflect->count, log));
  TRY(device_launch(
      device, &reflect->kernel, work_items(device, count), count,
      method == REFLECTIONS_ENVIRONMENT ? "look up the environment" : "look up cube maps",
      ARGS(ARG(map), ARG(rough_alone), ARG(closed), ARG_BUFFER(rays->rays), ARG_BUFFER(rays->slots),
           ARG(rays->capacity), ARG(count), ARG_BUFFER(scene->object_starts), ARG(scene->object_count),
           ARG_BUFFER(*of_object), ARG_BUFFER(reflect->cube_of_object), ARG(reflect->cube_count),
           ARG_BUFFER(reflect->cubes), ARG_BUFFER(reflect->texels), ARG_BUFFER(reflect->hull),
           ARG_BUFFER(reflect->cells), ARG_BUFFER(reflect->levels), ARG_BUFFER(scene->environment),
           ARG_BUFFER(scene->environment_pixels), ARG_BUFFER(reflect->environment_levels), ARG_BUFFER(*radiance),
           ARG_BUFFER(left->rays), ARG_BUFFER(left->slots), ARG_BUFFER(reflect->count)),
      log));
  TRY(buffer_read(device, &reflect->count, left_count, sizeof *left_count, log));
  reflect->looked_up += rough_alone ? count - *left_count : count;
  reflect->left += rough_alone ? 0 : *left_count;

done:
  return status;
}

#include "passes/cube_lit.h"

#include "passes/scene_args.h"

Status cube_lit_make(CubeLit *out, Device *device, const LightInfo *lights, uint32_t count, Log *log)
{
  Status status = STATUS_OK;
  CubeLit lit = {.light_count = count};
  Program *program = NULL;
  TRY(program_build(&program, device, "capture/cube_lit.cl", "", log));
  TRY(program_kernel(&lit.kernel, program, "cube_lit", log));
  TRY(buffer_create(&lit.lights, device, count * sizeof *lights, lights, "cube maps", log));
  TRY(buffer_create(&lit.faces, device, sizeof(uint32_t), NULL, "cube maps", log));
  *out = lit;
  lit = (CubeLit){0};

done:
  cube_lit_free(&lit);
  return status;
}

void cube_lit_free(CubeLit *lit)
{
  kernel_free(&lit->kernel);
  buffer_free(&lit->lights);
  buffer_free(&lit->faces);
  *lit = (CubeLit){0};
}

Status cube_lit_find(uint32_t *faces, const CubeLit *lit, Device *device, const CubeInfo *cube,
                     const DeviceBuffer *texels, float slack_m, Log *log)
{
  Status status = STATUS_OK;
  DeviceBuffer found = lit->faces;
  const size_t count = CUBE_TEXELS((size_t)cube->size);
  TRY(buffer_zero(device, &found, log));
  TRY(device_launch(
      device, &lit->kernel, work_items(device, count), count, "find where changed lights shine",
      ARGS(ARG(cube->center.x), ARG(cube->center.y), ARG(cube->center.z), ARG(cube->size), ARG(cube->first_texel),
           ARG_BUFFER(*texels), ARG_BUFFER(lit->lights), ARG(lit->light_count), ARG(slack_m), ARG_BUFFER(lit->faces)),
      log));
  TRY(buffer_read(device, &lit->faces, faces, sizeof *faces, log));

done:
  return status;
}

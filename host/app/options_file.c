// What options are before a command line is read: defaults, and what a scene file says.
#include <stdlib.h>
#include <unistd.h>

#include "app/file_keys.h"
#include "app/options.h"

RenderOptions render_options_default(void)
{
  uint64_t ram = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
  return (RenderOptions){
      .settings = {.width = 1280,
                   .height = 720,
                   .samples = 1,
                   .shadows = SHADOWS_RAYS,
                   .shadow_options = {.kernel_px = 3},
                   .reflections = REFLECTIONS_RAYS,
                   .max_depth = 8,
                   .max_roughness = MAX_ROUGHNESS_AUTO,
                   .ambient = 0.05f},
      .frames = {.step = 1},
      .environment_intensity = 1,
      .key_light = true,
      .overwrite = true,
      .max_memory_bytes = ram / 4 * 3,
      .max_image_pixels = 1ull << 28,
  };
}

Status render_options_read_file(RenderOptions *out, const char *scene_path, bool allow_outside, Log *log)
{
  Status status = STATUS_OK;
  *out = render_options_default();
  out->gltf_path = scene_path;
  if (!scene_file_is(scene_path)) return STATUS_OK;
  TRY(scene_file_read(&out->scene_file, scene_path, allow_outside, log));
  out->gltf_path = out->scene_file.scene_path;
  TRY(file_keys_read(out, &render_command_line, &out->scene_file, log));
  if (out->environment.choice == ENVIRONMENT_FILE) {
    TRY(scene_file_resolve(&out->environment_path, &out->scene_file, out->environment.text, allow_outside, log));
    out->environment.text = out->environment_path;
  }

done:
  return status;
}

void render_options_free(RenderOptions *options)
{
  scene_file_free(&options->scene_file);
  free(options->environment_path);
}

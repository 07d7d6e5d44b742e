// Command line of `frugal render`.
#pragma once

#include "plan/plan.h"
#include "render/picture.h"
#include "scene/scene.h"

typedef enum EnvironmentChoice { ENVIRONMENT_UNSET, ENVIRONMENT_NONE, ENVIRONMENT_SKY, ENVIRONMENT_COLOR, ENVIRONMENT_FILE } EnvironmentChoice;

typedef struct RenderOptions {
  const char *scene_path, *output_path;
  const char *format;  // png, jpg, exr, hdr
  RenderSettings settings;
  PictureOptions picture;
  const char *camera;  // index, name, "fit"; NULL: the first camera, else fit
  EnvironmentChoice environment;
  const char *environment_path;
  float environment_color[3];  // linear
  float environment_intensity;
  double environment_rotation_rad;
  bool key_light;
  bool allow_outside;
  const char *device;
  uint32_t threads, seed;
  uint64_t max_memory_bytes, max_image_pixels;
  bool profile, quiet, help;
  const char *stats_path, *trace_path;
} RenderOptions;

// Fills *out from argv[1..]. Errors: STATUS_USAGE, with the nearest option or value named.
Status render_options_parse(RenderOptions *out, int argc, char **argv, Log *log);

extern const char render_usage[];

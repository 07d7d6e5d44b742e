// Command line of `frugal render`.
#pragma once

#include "app/command_line.h"
#include "app/frames.h"
#include "plan/plan.h"
#include "render/picture.h"
#include "scene/scene_file.h"

typedef enum EnvironmentChoice {
  ENVIRONMENT_UNSET,
  ENVIRONMENT_NONE,
  ENVIRONMENT_SKY,
  ENVIRONMENT_COLOR,
  ENVIRONMENT_FILE
} EnvironmentChoice;

typedef struct EnvironmentSource {
  EnvironmentChoice choice;
  const char *text;  // as given: a path, for ENVIRONMENT_FILE
  float color[3];    // linear
} EnvironmentSource;

typedef enum BackgroundKind { BACKGROUND_ENVIRONMENT, BACKGROUND_TRANSPARENT, BACKGROUND_COLOR } BackgroundKind;

typedef struct Background {
  BackgroundKind kind;
  const char *text;  // as given; NULL: not given
  float color[3];    // linear
} Background;

typedef struct ExposureChoice {
  bool is_auto;
  float ev;
} ExposureChoice;

// width 0: the whole picture.
typedef struct Crop {
  uint32_t x, y, width, height;
} Crop;

// pixels 0 without `all`: nothing is verified.
typedef struct VerifyChoice {
  bool all;
  uint32_t pixels;
} VerifyChoice;

typedef struct RenderOptions {
  const char *scene_path, *output_path;
  const char *gltf_path;   // what scene_path is, or names
  SceneFile scene_file;    // owns texts of what follows
  char *environment_path;  // of an image that it names, or NULL
  const char *format;      // png, jpg, exr, hdr
  RenderSettings settings;
  Crop crop;
  PictureOptions picture;  // but for exposure and attributes
  ExposureChoice exposure;
  Background background;
  FrameRange frames;
  float fps;
  const char *animation;      // index or name; NULL: the first
  const char *light_shadows;  // NAME=METHOD,...; NULL: all lights as settings.shadows
  const char *camera;         // index, name, "fit"; NULL: the first camera, else fit
  EnvironmentSource environment;
  float environment_intensity;
  double environment_rotation_rad;
  bool key_light;
  bool allow_outside;
  const char *device;
  uint32_t threads, seed;
  uint64_t max_memory_bytes, max_image_pixels;
  bool overwrite, list_cameras;
  bool profile, progress, quiet, verbose, help;
  const char *stats_path, *trace_path;
  VerifyChoice verify;
} RenderOptions;

extern const CommandLine render_command_line;

// Fills *out from the scene file, if argv names one, and from argv[1..], which wins. To be freed also on failure.
// Errors: STATUS_USAGE, with the nearest option or value named; those of render_options_read_file.
Status render_options_parse(RenderOptions *out, int argc, char **argv, Log *log);

// Do options that are each right go together? Called with output_path and format set. Errors: STATUS_USAGE.
Status render_options_check(const RenderOptions *options, Log *log);

RenderOptions render_options_default(void);

// The defaults, and over them what the scene says where it is a scene file. To be freed also on failure. Errors: those
// of scene_file_read and file_keys_read.
Status render_options_read_file(RenderOptions *out, const char *scene_path, bool allow_outside, Log *log);

void render_options_free(RenderOptions *options);

// Reads --light-shadows, a const char * that is not copied: NAME=METHOD and so on (app/light_shadows.h).
Status option_read_light_shadows(void *field, const Option *option, const char *text, Log *log);

// The part of the whole picture that is rendered.
PictureArea render_area(const RenderOptions *options);

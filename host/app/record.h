// What a picture was made of and how: in the picture's metadata, for --stats, for -v.
#pragma once

#include <jansson.h>

#include "app/options.h"
#include "app/verify.h"
#include "device_scene/device_scene.h"
#include "passes/raster_visibility.h"
#include "render/reflection_bound.h"
#include "render/shadow_bound.h"

// One line that reads as the options that make the picture again, whatever was left to defaults spelt out: scene and
// environment file without their folders, the exposure that was used, what the device is. *out is freed by the caller.
// Errors: STATUS_NO_MEMORY.
Status record_make(char **out, const RenderOptions *options, const Plan *plan, const Camera *camera, float exposure_ev,
                   const DeviceInfo *device, Log *log);

typedef struct RecordSources {
  const RenderOptions *options;
  const char *record;  // of record_make
  float exposure_ev;
  const DeviceScene *scene;
  Device *device;
  const Plan *plan;
  const Timeline *timeline;
  const RasterCost *raster;         // NULL where rays found what the camera sees
  const Frame *frame;               // its shadow maps
  const ShadowBound *shadow_bound;  // NULL: there is none
  const ReflectionBound *reflection_bound;
  const VerifyResult *verify;  // NULL: nothing was verified
  double total_ms;
} RecordSources;

// What --stats writes; NULL when out of memory.
json_t *record_stats(const RecordSources *sources);

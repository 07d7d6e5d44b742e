// From a rendered frame to an image file: the picture and the AOVs asked for, in the form its format takes.
#pragma once

#include "image/image.h"
#include "render/frame.h"

enum AovName {
  AOV_NAME_DEPTH = 1 << 0,
  AOV_NAME_POSITION = 1 << 1,
  AOV_NAME_NORMAL = 1 << 2,
  AOV_NAME_ALBEDO = 1 << 3,
  AOV_NAME_OBJECT = 1 << 4,
  AOV_NAME_PRIMITIVE = 1 << 5,
  AOV_NAME_MATERIAL = 1 << 6,
  AOV_NAME_SHADOW = 1 << 7,
  AOV_NAME_REFLECTION = 1 << 8,
};

// AovSet that the names need.
uint32_t aov_set_of(uint32_t names);

typedef struct PictureOptions {
  uint32_t aovs;  // of AovName; EXR alone can hold them
  float exposure_ev;
  uint32_t tone;        // TONE_CURVE_*
  bool opaque;          // alpha 1; else it is the coverage
  bool has_background;  // opaque: `background` is laid behind the surfaces, past exposure and tone curve
  float background[3];  // linear
  uint32_t bit_depth, quality;
  const char *compression;
  const ImageAttribute *attributes;
  uint32_t attribute_count;
} PictureOptions;

// Memory that a picture of this size takes on host and device together, at most; AovNames make it more.
uint64_t picture_memory_bytes(const PictureArea *area, uint32_t aovs);

// The exposure that suits the frame (render/exposure.h); *out is 0 and a warning is sent where nothing is lit.
// Errors: STATUS_DEVICE, STATUS_NO_MEMORY.
Status picture_auto_exposure(float *ev, Frame *frame, Log *log);

// Of a frame with AOV_SET_SHADOW: direct light that arrives at first hits over direct light without shadows, 1 where
// there is none. out: [height][width]. Errors: STATUS_DEVICE, STATUS_NO_MEMORY.
Status picture_lit_shares(float *out, Frame *frame, Log *log);

// How sums of `samples` samples a pixel become the picture's values; `display`: those of PNG and JPEG.
ResolveInfo picture_resolve_info(const PictureOptions *options, const Frame *frame, uint32_t samples, bool display);

// Resolves the frame and writes it. EXR and HDR hold linear radiance, times 2^exposure; PNG and JPEG are
// display-encoded, and one that comes out empty, black or blown out is a warning that names an exposure to try.
// Errors: STATUS_USAGE (AOVs in a format that cannot hold them; unknown format), those of image_write.
Status picture_write(Frame *frame, const PictureOptions *options, ImageHelper *images, const char *path,
                     const char *format, Log *log);

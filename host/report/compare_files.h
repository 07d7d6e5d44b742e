// Picture files for a comparison: read without repairs, so that what is wrong with them shows.
#pragma once

#include "report/image_compare.h"

typedef struct ComparePicture {
  Image image;        // linear radiance, premultiplied alpha
  uint32_t channels;  // in the file: 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA
  bool is_display;    // PNG, JPEG; else EXR, HDR
} ComparePicture;

// With `ignore_alpha` alpha is read as 1, and counts for no channel. The caller frees out->image.
// Errors: those of image_read_layer.
Status compare_picture_read(ComparePicture *out, ImageHelper *helper, const char *path, bool ignore_alpha, Log *log);

// Do both have the same channels? Errors: STATUS_BAD_IMAGE.
Status compare_channels_check(const ComparePicture pictures[2], const char *const names[2], Log *log);

// Clears in `mask` ([height][width]) what `selection` does not name: `FILE:AOV=IDS`, with an id AOV of an EXR (object,
// primitive, material, or a channel's whole name) and ids with commas between, -1 being the background.
//
// Errors: STATUS_USAGE (not of that form), STATUS_BAD_IMAGE (another size, no such AOV or no ids in it, no pixel with
// any of them), those of image_read_layer.
Status compare_mask_select(uint8_t *mask, uint32_t width, uint32_t height, ImageHelper *helper, const char *selection,
                           Log *log);

// image_compare of two files, with their names in messages. Errors: those of the above.
Status image_compare_files(ImageError *out, ImageHelper *helper, const char *path_a, const char *path_b,
                           const ImageCompareOptions *options, Log *log);

// Image files, read and written. Decoding happens in a helper process that links OpenImageIO: the program itself
// starts without its 260 shared libraries, and a hostile file can break nothing but the helper.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/log.h"

typedef enum ImageKind {
  IMAGE_TEXTURE,   // RGBA, 8 bits a channel, as stored in the file (no colour conversion), straight alpha
  IMAGE_RADIANCE,  // RGBA, 32-bit float, linear
} ImageKind;

// Pixels are row-major from the top left, [height][width][4]; exactly one of the two is not NULL.
typedef struct Image {
  uint32_t width, height;
  uint8_t *texels;  // IMAGE_TEXTURE
  float *pixels;    // IMAGE_RADIANCE
} Image;

void image_free(Image *image);

// A helper process and the connection to it. Requests are answered in order; one thread at a time may use it.
typedef struct ImageHelper ImageHelper;

// Starts the helper and returns at once, while it loads its libraries (0.2 to 0.3 s). The helper is the program
// `frugal-image` beside this executable, or in ../libexec/frugal, or the one FRUGAL_IMAGE_HELPER names.
// Errors: STATUS_NOT_FOUND, STATUS_NO_MEMORY.
Status image_helper_start(ImageHelper **out, uint64_t max_image_pixels, Log *log);
void image_helper_stop(ImageHelper *helper);

// Decodes an image file held in memory (`size` bytes at `bytes`; `name` is for messages), or, with bytes NULL, the
// file at path `name`. The size in the file's header is checked before decoding. On failure *out is untouched.
//
// Errors: STATUS_NOT_FOUND, STATUS_BAD_IMAGE (also when the helper died of it), STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status image_read(Image *out, ImageHelper *helper, ImageKind kind, const char *name, const void *bytes, size_t size,
                  Log *log);

typedef enum ImageElement { IMAGE_UINT8, IMAGE_UINT16, IMAGE_UINT32, IMAGE_FLOAT } ImageElement;

// Channels as the file holds them: no colour conversion, nothing repaired, nothing added.
typedef struct ImageLayer {
  uint32_t width, height;
  uint32_t channels;  // of a picture: 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA; of a named channel: 1
  ImageElement element;
  bool is_display;  // PNG, JPEG: sRGB-encoded, straight alpha; else linear radiance, premultiplied
  void *values;     // [height][width][channels]
} ImageLayer;

void image_layer_free(ImageLayer *layer);

// Reads the picture of the file at `path`, or with `channel` not NULL the EXR channel of that name ("object.id").
// Integers stay integers, half floats become floats. On failure *out is untouched.
//
// Errors: those of image_read; STATUS_BAD_IMAGE where there is no such channel, with those that there are.
Status image_read_layer(ImageLayer *out, ImageHelper *helper, const char *path, const char *channel, Log *log);

// One output channel group: what an EXR calls a layer, e.g. {"R","G","B","A"} or {"depth.Z"}.
typedef struct ImageChannels {
  const char *names[4];
  uint32_t count;    // 1..4
  uint32_t stride;   // elements from pixel to pixel, >= count
  const void *data;  // [height][width][stride], float, or uint32_t where is_uint
  uint32_t is_uint;  // 32-bit unsigned integers: object, primitive and material ids
} ImageChannels;

typedef struct ImageAttribute {
  const char *name, *value;
} ImageAttribute;

// A picture to write. PNG and JPEG take one group of floats in [0, 1] that are display-encoded (sRGB, straight alpha)
// and quantise it with rounding; HDR takes one group of linear radiance; EXR takes any number of groups of either
// type.
typedef struct ImageOutput {
  uint32_t width, height;
  const ImageChannels *groups;
  uint32_t group_count;
  uint32_t bit_depth;       // PNG: 8 or 16
  uint32_t quality;         // JPEG: 1..100
  const char *compression;  // EXR: "zip", "none", "piz", ...; PNG: "0".."9"; NULL: the format's default
  const ImageAttribute *attributes;
  uint32_t attribute_count;
} ImageOutput;

// Writes a picture as the format that the file name's ending says (.png .jpg .jpeg .exr .hdr), or `format` where it is
// not NULL (path "-" is standard output and needs it). The file appears whole or not at all: a temporary file in the
// same folder, renamed.
//
// Errors: STATUS_USAGE (unknown ending), STATUS_OUTPUT, STATUS_NO_MEMORY.
Status image_write(ImageHelper *helper, const char *path, const char *format, const ImageOutput *output, Log *log);

// "png", "jpg", "exr" or "hdr" for a path by its ending; NULL for another.
const char *image_format_of(const char *path);

// Is `compression` one that the format ("png", "exr", ...) knows? NULL, the default, always is.
bool image_compression_is_known(const char *format, const char *compression);

// Removes the temporary files of writes under way. For a signal handler that is about to end the program:
// async-signal-safe.
void image_remove_temporaries(void);

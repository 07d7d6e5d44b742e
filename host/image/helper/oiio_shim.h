// OpenImageIO as the helper needs it, for C. Files are named by path and their formats given, never guessed; messages
// are `cause: hint`; no exception leaves.
#pragma once

#include "base/log.h"
#include "image/image.h"
#include "image/protocol.h"

typedef struct OiioInput OiioInput;

// Limits OpenImageIO's and OpenEXR's own threads.
void oiio_set_up(void);

// Opens an image and reads its size, in pixels, from its header. Errors: STATUS_BAD_IMAGE, STATUS_NO_MEMORY.
Status oiio_open(OiioInput **out, uint32_t *width, uint32_t *height, ImageFormat format, const char *path, Log *log);

// Decodes to [height][width][4]: uint8_t for IMAGE_TEXTURE (16 bits are rounded), float for IMAGE_RADIANCE, with the
// file's values as they are (integers scaled to [0, 1]) and straight alpha kept straight. Grey is repeated, missing
// alpha is opaque, further channels are left out. Errors: STATUS_BAD_IMAGE, STATUS_NO_MEMORY.
Status oiio_decode(OiioInput *input, ImageKind kind, void *rgba, Log *log);

// What a layer is: channels `first` and on, of one element. `channel`: the name of one, or empty for the picture.
typedef struct OiioLayer {
  uint32_t first, channels;
  ImageElement element;
} OiioLayer;

// Errors: STATUS_BAD_IMAGE (no such channel, no colours), STATUS_NO_MEMORY.
Status oiio_layer_find(OiioLayer *out, const OiioInput *input, const char *channel, Log *log);

// Decodes a layer to [height][width][channels] as it is in the file. Errors: STATUS_BAD_IMAGE, STATUS_NO_MEMORY.
Status oiio_layer_decode(OiioInput *input, const OiioLayer *layer, void *values, Log *log);

void oiio_close(OiioInput *input);

// Writes the picture that `request` describes; `pixels` and `text` are as protocol.h lays them out. The same input
// gives the same bytes. Errors: STATUS_OUTPUT, STATUS_NO_MEMORY.
Status oiio_encode(const char *path, const ImageRequest *request, const void *pixels, const char *text, Log *log);

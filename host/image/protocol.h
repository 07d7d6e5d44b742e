// Messages between the program and its image helper, over a SOCK_SEQPACKET pair: each request is one struct, each reply
// another, with at most one file descriptor beside it. Both ends are of one build, so the structs travel as they are.
//
// A decode request carries the descriptor of the image file (a real file, or its bytes in a memfd); the reply carries
// a memfd with the pixels, [height][width][4], or, for a layer, [height][width][channels]. An encode request carries a
// memfd with the pixels, [height][width][channels], followed by NUL-terminated strings: the compression (empty for the
// default), a name for each channel with its type ('f' or 'u') in front, then attributes as name and value in turn;
// the reply carries a memfd with the finished file.
#pragma once

#include "image/image.h"

enum { IMAGE_PROTOCOL = 0x46490002 };

typedef enum ImageFormat { IMAGE_PNG, IMAGE_JPEG, IMAGE_HDR, IMAGE_EXR, IMAGE_FORMAT_COUNT } ImageFormat;

typedef enum ImageOperation { IMAGE_DECODE, IMAGE_DECODE_LAYER, IMAGE_ENCODE } ImageOperation;

enum { IMAGE_CHANNEL_NAME_BYTES = 256 };

typedef struct ImageRequest {
  uint32_t protocol, operation;
  uint32_t kind;           // decode: an ImageKind
  uint32_t format;         // encode, as all below except max_pixels: an ImageFormat
  uint32_t width, height;  // pixels
  uint32_t channels;
  uint32_t element_bits;  // PNG and JPEG: 8 or 16 (unsigned), else 32
  uint32_t quality;
  uint64_t pixel_bytes, text_bytes;
  uint64_t max_pixels;                     // decode
  char channel[IMAGE_CHANNEL_NAME_BYTES];  // decode of a layer: the channel's name; empty for the picture
} ImageRequest;

// Size of an ImageElement.
static inline uint32_t image_element_bytes(uint32_t element)
{
  return element == IMAGE_UINT8 ? 1 : element == IMAGE_UINT16 ? 2 : 4;
}

typedef struct ImageReply {
  uint32_t protocol, status;
  uint32_t width, height;         // decode, in pixels
  uint64_t not_finite, negative;  // decode: pixels with such values
  uint32_t channels, element;     // decode of a layer, as ImageLayer; element: an ImageElement
  uint32_t is_display;
  char message[512];  // `cause: hint` where status is not STATUS_OK
} ImageReply;

// What an image file is, by its first bytes: never by its name.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/log.h"
#include "image/protocol.h"

// Recognises the format and refuses, before a decoder sees them, files that OpenImageIO would abort on or quietly
// complete: a PNG of more than `max_pixels` by its header, a JPEG that ends early. Messages are `cause: hint`.
//
// Errors: STATUS_BAD_IMAGE, STATUS_TOO_LARGE.
Status signature_check(ImageFormat *out, const uint8_t *bytes, size_t size, uint64_t max_pixels, Log *log);

// STATUS_BAD_IMAGE where there are no pixels, STATUS_TOO_LARGE where there are too many.
Status pixel_count_check(uint64_t width, uint64_t height, uint64_t max_pixels, Log *log);

// libFuzzer on what the image helper asks of a file's first bytes before a decoder sees it.

#include <stdlib.h>
#include <string.h>

#include "image/helper/signature.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size)
{
  ImageFormat format = IMAGE_FORMAT_COUNT;
  Log log = {0};
  Status status = signature_check(&format, data, size, 1 << 20, &log);
  if (status ? !strchr(log.error, ':') : format >= IMAGE_FORMAT_COUNT) abort();
  return 0;
}

#include "scene/gltf_context.h"

#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/large_array.h"
#include "scene/gltf_guard.h"
#include "scene/gltf_shim.h"

Status gltf_open(Gltf *gltf)
{
  Status status = STATUS_OK;
  char *json = NULL;
  TRY(gltf_guard(&json, gltf));
  TRY(gltf_shim_load(&gltf->model, json, strlen(json), gltf->path, gltf->log));

done:
  free(json);
  return status;
}

void gltf_close(Gltf *gltf)
{
  gltf_shim_free(gltf->model);
  json_decref(gltf->document);
  for (uint32_t i = 0; i < gltf->buffer_count; i++) free(gltf->buffers[i].owned);
  free(gltf->buffers);
  free(gltf->images);
  free(gltf->file.owned);
  *gltf = (Gltf){0};
}

Status gltf_fail(Gltf *gltf, Status status, const char *hint, const char *format, ...)
{
  char cause[512];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(cause, sizeof cause, format, arguments);
  va_end(arguments);
  return log_fail(gltf->log, status, "%s: %s: %s", gltf->path, cause, hint);
}

Status gltf_allocate(void *out, Gltf *gltf, uint64_t count, size_t element_bytes)
{
  void *memory = NULL;
  uint64_t bytes = 0, limit = gltf->options->max_memory_bytes;
  bool overflows = __builtin_mul_overflow(count, element_bytes, &bytes) || bytes > PTRDIFF_MAX ||
                   __builtin_add_overflow(gltf->used_bytes, bytes, &gltf->used_bytes);
  if (overflows || (limit && gltf->used_bytes > limit))
    return gltf_fail(gltf, STATUS_TOO_LARGE, "raise --max-memory or draw a smaller scene",
                     "%s needs more memory than allowed", gltf->where[0] ? gltf->where : "the scene");
  memory = huge_pages_ask(calloc(bytes ? bytes : 1, 1), bytes);
  memcpy(out, &memory, sizeof memory);
  return memory ? STATUS_OK : log_no_memory(gltf->log, gltf->path);
}

Status gltf_copy_name(char **out, Gltf *gltf, const char *name)
{
  size_t size = strlen(name) + 1;
  Status status = gltf_allocate(out, gltf, size, 1);
  if (!status) memcpy(*out, name, size);
  return status;
}

#include "scene/gltf_accessors.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef void (*Decoder)(void *out, const uint8_t *element, const GltfAccessor *from);

static uint32_t component_bytes(int type) { return type <= COMPONENT_UBYTE ? 1 : type <= COMPONENT_USHORT ? 2 : 4; }

static uint32_t unsigned_at(const uint8_t *at, int type)
{
  uint16_t u16;
  uint32_t u32;
  if (type == COMPONENT_UBYTE) return *at;
  if (type == COMPONENT_USHORT) return memcpy(&u16, at, sizeof u16), u16;
  return memcpy(&u32, at, sizeof u32), u32;
}

static float float_of_integer(const uint8_t *at, int type, bool normalized)
{
  int16_t s16;
  switch (type) {
    case COMPONENT_BYTE: return normalized ? fmaxf((float)(int8_t)*at / 127, -1) : (float)(int8_t)*at;
    case COMPONENT_SHORT: memcpy(&s16, at, sizeof s16); return normalized ? fmaxf((float)s16 / 32767, -1) : (float)s16;
    case COMPONENT_UBYTE: return normalized ? (float)*at / 255 : (float)*at;
    case COMPONENT_USHORT: return (float)unsigned_at(at, type) / (normalized ? 65535.0f : 1.0f);
    default: return (float)(unsigned_at(at, type) / (normalized ? 4294967295.0 : 1.0));
  }
}

static void floats_decode(void *out, const uint8_t *element, const GltfAccessor *from)
{
  uint32_t bytes = component_bytes(from->values.type);
  if (from->values.type == COMPONENT_FLOAT) {
    memcpy(out, element, from->components * sizeof(float));
    return;
  }
  for (uint32_t c = 0; c < from->components; c++)
    ((float *)out)[c] = float_of_integer(element + c * bytes, from->values.type, from->normalized);
}

static void indices_decode(void *out, const uint8_t *element, const GltfAccessor *from)
{
  uint32_t bytes = component_bytes(from->values.type);
  for (uint32_t c = 0; c < from->components; c++)
    ((uint32_t *)out)[c] = unsigned_at(element + c * bytes, from->values.type);
}

static const uint8_t *span_first(const Gltf *gltf, const GltfSpan *span)
{
  const GltfView *view = &gltf->model->views[span->view];
  return gltf->buffers[view->buffer].bytes + view->offset + span->offset;
}

// Decodes each element into `out`, `out_bytes` apart, then those that the sparse part replaces.
static Status elements_decode(uint8_t *out, size_t out_bytes, Gltf *gltf, int accessor, Decoder decode)
{
  const GltfAccessor *from = &gltf->model->accessors[accessor];
  uint64_t element_bytes = (uint64_t)from->components * component_bytes(from->values.type);
  if (from->values.view != NONE) {
    const uint8_t *first = span_first(gltf, &from->values);
    uint32_t view_stride = gltf->model->views[from->values.view].stride;
    uint64_t stride = view_stride ? view_stride : element_bytes;
    for (uint64_t i = 0; i < from->count; i++) decode(out + i * out_bytes, first + i * stride, from);
  }
  if (from->sparse_count == 0) return STATUS_OK;
  const uint8_t *indices = span_first(gltf, &from->sparse_indices), *values = span_first(gltf, &from->sparse_values);
  uint32_t index_bytes = component_bytes(from->sparse_indices.type);
  for (uint64_t i = 0; i < from->sparse_count; i++) {
    uint32_t index = unsigned_at(indices + i * index_bytes, from->sparse_indices.type);
    if (index >= from->count)
      return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "accessors[%d].sparse replaces element %u of %llu",
                       accessor, index, (unsigned long long)from->count);
    decode(out + index * out_bytes, values + i * element_bytes, from);
  }
  return STATUS_OK;
}

static Status shape_check(Gltf *gltf, int accessor, uint32_t components, uint32_t least, uint64_t count)
{
  const GltfAccessor *from = &gltf->model->accessors[accessor];
  bool is_matrix = components == 16;
  if (from->components < least || from->components > components || from->is_matrix != is_matrix)
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s: accessors[%d] has %u components, not %u",
                     gltf->where, accessor, from->components, components);
  if (count && from->count != count)
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s: accessors[%d] has %llu elements, not %llu",
                     gltf->where, accessor, (unsigned long long)from->count, (unsigned long long)count);
  return STATUS_OK;
}

Status gltf_read_floats(void *out, Gltf *gltf, int accessor, uint32_t components, uint32_t least, uint64_t count)
{
  Status status = STATUS_OK;
  const GltfAccessor *from = &gltf->model->accessors[accessor];
  float *floats = NULL;
  TRY(shape_check(gltf, accessor, components, least, count));
  TRY(gltf_allocate(&floats, gltf, from->count, components * sizeof *floats));
  for (uint64_t i = 0; from->components < components && i < from->count * components; i++) floats[i] = 1;
  TRY(elements_decode((uint8_t *)floats, components * sizeof *floats, gltf, accessor, floats_decode));
  for (uint64_t i = 0; i < from->count * components; i++)
    if (!isfinite(floats[i])) {
      status =
          gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s: accessors[%d] element %llu is not a finite number",
                    gltf->where, accessor, (unsigned long long)(i / components));
      goto done;
    }
  memcpy(out, &floats, sizeof floats);
  floats = NULL;

done:
  free(floats);
  return status;
}

Status gltf_read_indices(void *out, Gltf *gltf, int accessor, uint32_t components, uint64_t count, uint64_t limit)
{
  Status status = STATUS_OK;
  const GltfAccessor *from = &gltf->model->accessors[accessor];
  uint32_t *indices = NULL;
  TRY(shape_check(gltf, accessor, components, components, count));
  if (from->values.type != COMPONENT_UBYTE && from->values.type != COMPONENT_USHORT &&
      from->values.type != COMPONENT_UINT) {
    status = gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR,
                       "%s: accessors[%d] holds indices that are not unsigned", gltf->where, accessor);
    goto done;
  }
  TRY(gltf_allocate(&indices, gltf, from->count, components * sizeof *indices));
  TRY(elements_decode((uint8_t *)indices, components * sizeof *indices, gltf, accessor, indices_decode));
  for (uint64_t i = 0; i < from->count * components; i++)
    if (indices[i] >= limit) {
      status =
          gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s: accessors[%d] holds the index %u, the limit is %llu",
                    gltf->where, accessor, indices[i], (unsigned long long)limit);
      goto done;
    }
  memcpy(out, &indices, sizeof indices);
  indices = NULL;

done:
  free(indices);
  return status;
}

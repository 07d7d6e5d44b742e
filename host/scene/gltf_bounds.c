#include <string.h>

#include "scene/gltf_guard.h"
#include "scene/gltf_json.h"

// Bytes of one component, 0 for a type that glTF 2.0 does not have.
static uint64_t component_bytes(uint64_t type)
{
  switch (type) {
    case COMPONENT_BYTE:
    case COMPONENT_UBYTE: return 1;
    case COMPONENT_SHORT:
    case COMPONENT_USHORT: return 2;
    case COMPONENT_UINT:
    case COMPONENT_FLOAT: return 4;
    default: return 0;
  }
}

// Bytes of one element: the columns of a matrix begin at multiples of four.
static uint64_t element_bytes(const char *type, uint64_t bytes)
{
  uint64_t side = type[0] == 'S' ? 1 : (uint64_t)(type[3] - '0');
  return type[0] != 'M' ? side * bytes : side * ((side * bytes + 3) & ~3ull);
}

// Do `count` elements, `stride` apart, of `size` bytes each lie in the view from `offset` on?
static bool span_fits(const json_t *view, uint64_t offset, uint64_t count, uint64_t stride, uint64_t size)
{
  uint64_t end = 0;
  return count > 0 && !__builtin_mul_overflow(count - 1, stride, &end) && !__builtin_add_overflow(end, size, &end) &&
         !__builtin_add_overflow(end, offset, &end) && end <= gltf_json_uint(view, "byteLength", 0);
}

static Status view_check(Gltf *gltf, size_t index, const json_t *view)
{
  const GltfBytes *buffer = &gltf->buffers[gltf_json_uint(view, "buffer", 0)];
  uint64_t offset = gltf_json_uint(view, "byteOffset", 0), size = gltf_json_uint(view, "byteLength", 0);
  uint64_t stride = gltf_json_uint(view, "byteStride", 4);
  if (offset > buffer->size || size > buffer->size - offset)
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "bufferViews[%zu] leaves its buffer of %llu bytes",
                     index, (unsigned long long)buffer->size);
  if (stride < 4 || stride > 252)
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "bufferViews[%zu].byteStride is %llu, not 4 to 252",
                     index, (unsigned long long)stride);
  return STATUS_OK;
}

static const json_t *view_of(Gltf *gltf, const json_t *span)
{
  return json_array_get(json_object_get(gltf->document, "bufferViews"), gltf_json_uint(span, "bufferView", 0));
}

static Status sparse_check(Gltf *gltf, size_t index, const json_t *sparse, uint64_t count, uint64_t size)
{
  const json_t *indices = json_object_get(sparse, "indices"), *values = json_object_get(sparse, "values");
  uint64_t sparse_count = gltf_json_uint(sparse, "count", 0), type = gltf_json_uint(indices, "componentType", 0);
  uint64_t index_bytes = component_bytes(type);
  uint64_t indices_offset = gltf_json_uint(indices, "byteOffset", 0),
           values_offset = gltf_json_uint(values, "byteOffset", 0);
  if (type != COMPONENT_UBYTE && type != COMPONENT_USHORT && type != COMPONENT_UINT)
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "accessors[%zu].sparse.indices has component type %llu",
                     index, (unsigned long long)type);
  if (sparse_count > count || indices_offset > INT32_MAX || values_offset > INT32_MAX ||
      !span_fits(view_of(gltf, indices), indices_offset, sparse_count, index_bytes, index_bytes) ||
      !span_fits(view_of(gltf, values), values_offset, sparse_count, size, size))
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR,
                     "accessors[%zu].sparse with %llu elements is out of bounds", index,
                     (unsigned long long)sparse_count);
  return STATUS_OK;
}

static Status accessor_check(Gltf *gltf, size_t index, const json_t *accessor)
{
  const json_t *sparse = json_object_get(accessor, "sparse");
  uint64_t type = gltf_json_uint(accessor, "componentType", 0), count = gltf_json_uint(accessor, "count", 0);
  uint64_t bytes = component_bytes(type);
  uint64_t size = element_bytes(json_string_value(json_object_get(accessor, "type")), bytes);
  if (bytes == 0)
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "accessors[%zu] has component type %llu", index,
                     (unsigned long long)type);
  if (count == 0 || count > INT32_MAX)
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "accessors[%zu] has a count of %llu", index,
                     (unsigned long long)count);
  if (json_object_get(accessor, "bufferView")) {
    const json_t *view = view_of(gltf, accessor);
    if (!span_fits(view, gltf_json_uint(accessor, "byteOffset", 0), count, gltf_json_uint(view, "byteStride", size),
                   size))
      return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "accessors[%zu] with %llu elements leaves its view",
                       index, (unsigned long long)count);
  }
  return sparse ? sparse_check(gltf, index, sparse, count, size) : STATUS_OK;
}

Status gltf_check_bounds(Gltf *gltf)
{
  Status status = STATUS_OK;
  size_t i;
  json_t *entry;
  const json_t *views = json_object_get(gltf->document, "bufferViews");
  const json_t *accessors = json_object_get(gltf->document, "accessors");
  json_array_foreach(views, i, entry) { TRY(view_check(gltf, i, entry)); }
  json_array_foreach(accessors, i, entry) { TRY(accessor_check(gltf, i, entry)); }

done:
  return status;
}

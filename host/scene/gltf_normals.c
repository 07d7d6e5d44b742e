#include <stdlib.h>
#include <string.h>

#include "scene/gltf_mesh.h"

// Twice the area along the normal of triangle `i`.
static Vec3 face_vector(const Primitive *primitive, uint32_t i)
{
  const uint32_t *corners = primitive->triangles[i];
  Vec3 a = vec3_from_floats(primitive->positions[corners[0]]);
  Vec3 b = vec3_from_floats(primitive->positions[corners[1]]);
  Vec3 c = vec3_from_floats(primitive->positions[corners[2]]);
  return vec3_cross(vec3_sub(b, a), vec3_sub(c, a));
}

static void floats_from_unit(float out[3], Vec3 v, Vec3 fallback)
{
  v = vec3_unit_or(v, fallback);
  out[0] = (float)v.x;
  out[1] = (float)v.y;
  out[2] = (float)v.z;
}

// Replaces a vertex array by one element a triangle corner; absent arrays stay so. `array`: address of its pointer.
static Status array_unshare(void *array, Gltf *gltf, const Primitive *primitive, size_t element_bytes)
{
  uint8_t *shared, *unshared = NULL;
  memcpy(&shared, array, sizeof shared);
  if (!shared) return STATUS_OK;
  Status status = gltf_allocate(&unshared, gltf, 3ull * primitive->triangle_count, element_bytes);
  if (status) return status;
  for (uint32_t i = 0; i < primitive->triangle_count; i++)
    for (uint32_t corner = 0; corner < 3; corner++)
      memcpy(unshared + (3ull * i + corner) * element_bytes, shared + primitive->triangles[i][corner] * element_bytes,
             element_bytes);
  free(shared);
  memcpy(array, &unshared, sizeof unshared);
  return STATUS_OK;
}

static Status flat_normals_make(Primitive *primitive, Gltf *gltf)
{
  Status status = STATUS_OK;
  uint64_t vertex_count = 3ull * primitive->triangle_count;
  if (vertex_count > UINT32_MAX)
    return gltf_fail(gltf, STATUS_TOO_LARGE, "split the mesh", "%s has too many triangles", gltf->where);
  free(primitive->tangents);  // without normals, given tangents mean nothing
  primitive->tangents = NULL;
  TRY(array_unshare(&primitive->positions, gltf, primitive, sizeof *primitive->positions));
  TRY(array_unshare(&primitive->uvs[0], gltf, primitive, sizeof *primitive->uvs[0]));
  TRY(array_unshare(&primitive->uvs[1], gltf, primitive, sizeof *primitive->uvs[1]));
  TRY(array_unshare(&primitive->colors, gltf, primitive, sizeof *primitive->colors));
  TRY(gltf_allocate(&primitive->normals, gltf, vertex_count, sizeof *primitive->normals));
  primitive->vertex_count = (uint32_t)vertex_count;
  for (uint32_t i = 0; i < primitive->triangle_count; i++) {
    for (uint32_t corner = 0; corner < 3; corner++) primitive->triangles[i][corner] = 3 * i + corner;
    for (uint32_t corner = 0; corner < 3; corner++)
      floats_from_unit(primitive->normals[3 * i + corner], face_vector(primitive, i), vec3(0, 0, 1));
  }

done:
  return status;
}

static bool is_zero(const float v[3]) { return v[0] == 0 && v[1] == 0 && v[2] == 0; }

static Status zero_normals_replace(Primitive *primitive, Gltf *gltf)
{
  Status status = STATUS_OK;
  Vec3 *sums = NULL;
  bool any = false;
  for (uint32_t i = 0; i < primitive->vertex_count && !any; i++) any = is_zero(primitive->normals[i]);
  if (!any) return STATUS_OK;
  TRY(gltf_allocate(&sums, gltf, primitive->vertex_count, sizeof *sums));
  for (uint32_t i = 0; i < primitive->triangle_count; i++)
    for (uint32_t corner = 0; corner < 3; corner++) {
      Vec3 *sum = &sums[primitive->triangles[i][corner]];
      *sum = vec3_add(*sum, face_vector(primitive, i));
    }
  for (uint32_t i = 0; i < primitive->vertex_count; i++)
    if (is_zero(primitive->normals[i])) floats_from_unit(primitive->normals[i], sums[i], vec3(0, 0, 1));

done:
  free(sums);
  return status;
}

Status gltf_normals_finish(Primitive *primitive, Gltf *gltf)
{
  Status status = STATUS_OK;
  if (!primitive->normals) return flat_normals_make(primitive, gltf);
  TRY(zero_normals_replace(primitive, gltf));
  for (uint32_t i = 0; i < primitive->vertex_count; i++) {
    floats_from_unit(primitive->normals[i], vec3_from_floats(primitive->normals[i]), vec3(0, 0, 1));
    if (!primitive->tangents) continue;
    floats_from_unit(primitive->tangents[i], vec3_from_floats(primitive->tangents[i]), vec3(1, 0, 0));
    primitive->tangents[i][3] = primitive->tangents[i][3] < 0 ? -1 : 1;
  }

done:
  return status;
}

#include "scene/gltf_mesh.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/gltf_accessors.h"

// Corner `corner` of triangle `i` of a list, strip or fan, as a place in the vertex sequence. glTF 2.0, 3.7.2.1.
static uint32_t sequence_at(int mode, uint32_t i, uint32_t corner)
{
  if (mode == MODE_FAN) return corner == 2 ? 0 : i + 1 + corner;
  if (mode == MODE_STRIP) return corner == 0 ? i : i + (corner == 1 ? 1 + i % 2 : 2 - i % 2);
  return 3 * i + corner;
}

static Status triangles_read(Primitive *out, Gltf *gltf, const GltfPrimitive *from)
{
  Status status = STATUS_OK;
  uint32_t *indices = NULL;
  uint64_t length = out->vertex_count;
  if (from->indices != NONE) {
    TRY(gltf_read_indices(&indices, gltf, from->indices, 1, 0, out->vertex_count));
    length = gltf->model->accessors[from->indices].count;
  }
  out->triangle_count = (uint32_t)(from->mode == MODE_TRIANGLES ? length / 3 : length < 3 ? 0 : length - 2);
  TRY(gltf_allocate(&out->triangles, gltf, out->triangle_count, sizeof *out->triangles));
  for (uint32_t i = 0; i < out->triangle_count; i++)
    for (uint32_t corner = 0; corner < 3; corner++) {
      uint32_t at = sequence_at(from->mode, i, corner);
      out->triangles[i][corner] = indices ? indices[at] : at;
    }

done:
  free(indices);
  return status;
}

static Status attribute_read(void *out, Gltf *gltf, const GltfPrimitive *from, Attribute attribute, uint32_t components,
                             uint32_t least, uint64_t count)
{
  int accessor = from->attributes[attribute];
  return accessor == NONE ? STATUS_OK : gltf_read_floats(out, gltf, accessor, components, least, count);
}

// The primitive in a pose; where `has_colors` is false, without what no pose changes: UVs and colours.
static Status primitive_read(Primitive *out, Gltf *gltf, const GltfPrimitive *from, const GltfPose *pose,
                             bool has_colors)
{
  Status status = STATUS_OK;
  uint64_t count = gltf->model->accessors[from->attributes[ATTRIBUTE_POSITION]].count;
  out->vertex_count = (uint32_t)count;
  out->material = from->material != NONE ? from->material : (int)gltf->model->material_count;
  TRY(attribute_read(&out->positions, gltf, from, ATTRIBUTE_POSITION, 3, 3, count));
  TRY(attribute_read(&out->normals, gltf, from, ATTRIBUTE_NORMAL, 3, 3, count));
  TRY(attribute_read(&out->tangents, gltf, from, ATTRIBUTE_TANGENT, 4, 4, count));
  if (has_colors) {
    TRY(attribute_read(&out->uvs[0], gltf, from, ATTRIBUTE_TEXCOORD_0, 2, 2, count));
    TRY(attribute_read(&out->uvs[1], gltf, from, ATTRIBUTE_TEXCOORD_1, 2, 2, count));
    TRY(attribute_read(&out->colors, gltf, from, ATTRIBUTE_COLOR_0, 4, 3, count));
  }
  TRY(gltf_pose_apply(out, gltf, from, pose));
  TRY(triangles_read(out, gltf, from));
  TRY(gltf_normals_finish(out, gltf));

done:
  return status;
}

// Why it draws no triangles, or NULL.
static const char *primitive_flaw(const GltfPrimitive *primitive)
{
  return primitive->mode < MODE_TRIANGLES                    ? "points or lines are not drawn"
         : primitive->mode > MODE_FAN                        ? "has an unknown mode and is not drawn"
         : primitive->attributes[ATTRIBUTE_POSITION] == NONE ? "has no positions and is not drawn"
                                                             : NULL;
}

static void where_set(Gltf *gltf, int mesh, uint32_t primitive)
{
  snprintf(gltf->where, sizeof gltf->where, "meshes[%d] '%.64s' primitives[%u]", mesh, gltf->model->meshes[mesh].name,
           primitive);
}

Status gltf_mesh_read(Mesh *out, Gltf *gltf, int mesh, const GltfPose *pose)
{
  Status status = STATUS_OK;
  const GltfMesh *from = &gltf->model->meshes[mesh];
  TRY(gltf_copy_name(&out->name, gltf, from->name));
  TRY(gltf_allocate(&out->primitives, gltf, from->primitive_count, sizeof *out->primitives));
  for (uint32_t i = 0; i < from->primitive_count; i++) {
    const char *flaw = primitive_flaw(&from->primitives[i]);
    where_set(gltf, mesh, i);
    if (flaw) {
      log_warn(gltf->log, "%s: %s: %s", gltf->path, gltf->where, flaw);
      continue;
    }
    Primitive *primitive = &out->primitives[out->primitive_count++];
    TRY(primitive_read(primitive, gltf, &from->primitives[i], pose, true));
    if (primitive->triangle_count == 0) primitive_free(&out->primitives[--out->primitive_count]);
  }

done:
  gltf->where[0] = 0;
  return status;
}

// Vertices of the same primitive in another pose, into the arrays that are there.
static void vertices_copy(Primitive *to, const Primitive *from)
{
  memcpy(to->positions, from->positions, to->vertex_count * sizeof *to->positions);
  memcpy(to->normals, from->normals, to->vertex_count * sizeof *to->normals);
  if (to->tangents) memcpy(to->tangents, from->tangents, to->vertex_count * sizeof *to->tangents);
}

Status gltf_mesh_pose(Mesh *out, Gltf *gltf, int mesh, const GltfPose *pose)
{
  Status status = STATUS_OK;
  const GltfMesh *from = &gltf->model->meshes[mesh];
  Primitive posed = {0};
  for (uint32_t i = 0, drawn = 0; i < from->primitive_count; i++) {
    if (primitive_flaw(&from->primitives[i])) continue;
    where_set(gltf, mesh, i);
    TRY(primitive_read(&posed, gltf, &from->primitives[i], pose, false));
    if (posed.triangle_count > 0) vertices_copy(&out->primitives[drawn++], &posed);
    primitive_free(&posed);
  }

done:
  primitive_free(&posed);
  gltf->where[0] = 0;
  return status;
}

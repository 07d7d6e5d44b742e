// Morph targets and skins, applied on the host for the pose that the file is in at rest.
#include <stdlib.h>

#include "scene/gltf_accessors.h"
#include "scene/gltf_mesh.h"

// Adds weight x delta to the first three of `width` floats of each vertex.
static Status deltas_add(float *values, uint32_t width, Gltf *gltf, int accessor, double weight, uint64_t count)
{
  Status status = STATUS_OK;
  float(*deltas)[3] = NULL;
  if (!values || accessor == NONE || weight == 0) return STATUS_OK;
  TRY(gltf_read_floats(&deltas, gltf, accessor, 3, 3, count));
  for (uint64_t i = 0; i < count; i++)
    for (uint32_t c = 0; c < 3; c++) values[i * width + c] += (float)(weight * deltas[i][c]);

done:
  free(deltas);
  return status;
}

static Status morph_apply(Primitive *primitive, Gltf *gltf, const GltfPrimitive *from, const GltfPose *pose)
{
  Status status = STATUS_OK;
  uint64_t count = primitive->vertex_count;
  for (uint32_t i = 0; i < from->target_count; i++) {
    double weight = i < pose->weight_count ? pose->weights[i] : 0;
    TRY(deltas_add((float *)primitive->positions, 3, gltf, from->targets[i][ATTRIBUTE_POSITION], weight, count));
    TRY(deltas_add((float *)primitive->normals, 3, gltf, from->targets[i][ATTRIBUTE_NORMAL], weight, count));
    TRY(deltas_add((float *)primitive->tangents, 4, gltf, from->targets[i][ATTRIBUTE_TANGENT], weight, count));
  }

done:
  return status;
}

static void vector_store(float out[3], Vec3 v)
{
  out[0] = (float)v.x;
  out[1] = (float)v.y;
  out[2] = (float)v.z;
}

static void vertex_move(Primitive *primitive, uint32_t i, const Mat4 *world_from_bind)
{
  double side = mat4_determinant3(world_from_bind) < 0 ? -1 : 1;
  vector_store(primitive->positions[i], mat4_point(world_from_bind, vec3_from_floats(primitive->positions[i])));
  if (primitive->normals) {
    Vec3 normal = mat4_normal(world_from_bind, vec3_from_floats(primitive->normals[i]));
    vector_store(primitive->normals[i], vec3_scale(vec3_unit_or(normal, vec3(0, 0, 0)), side));
  }
  if (primitive->tangents)
    vector_store(primitive->tangents[i], mat4_direction(world_from_bind, vec3_from_floats(primitive->tangents[i])));
}

// One set of four joints and weights a vertex, added to the blended matrices and their sums of weights.
static Status joints_add(Mat4 *blends, double *sums, Gltf *gltf, int joints_accessor, int weights_accessor,
                         uint64_t count, const GltfPose *pose)
{
  Status status = STATUS_OK;
  uint32_t(*joints)[4] = NULL;
  float(*weights)[4] = NULL;
  TRY(gltf_read_indices(&joints, gltf, joints_accessor, 4, count, pose->joint_count));
  TRY(gltf_read_floats(&weights, gltf, weights_accessor, 4, 4, count));
  for (uint64_t i = 0; i < count; i++)
    for (int k = 0; k < 4; k++) {
      const Mat4 *joint = &pose->world_from_bind[joints[i][k]];
      for (int e = 0; e < 16; e++) blends[i].m[e] += weights[i][k] * joint->m[e];
      sums[i] += weights[i][k];
    }

done:
  free(joints);
  free(weights);
  return status;
}

static Status skin_apply(Primitive *primitive, Gltf *gltf, const GltfPrimitive *from, const GltfPose *pose)
{
  Status status = STATUS_OK;
  Mat4 *blends = NULL;
  double *sums = NULL;
  uint64_t count = primitive->vertex_count;
  TRY(gltf_allocate(&blends, gltf, count, sizeof *blends));
  TRY(gltf_allocate(&sums, gltf, count, sizeof *sums));
  for (int set = 0; set < 2; set++) {
    int joints = from->attributes[ATTRIBUTE_JOINTS_0 + set], weights = from->attributes[ATTRIBUTE_WEIGHTS_0 + set];
    if (joints == NONE || weights == NONE) {
      if (set == 1) continue;
      status = gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s has a skin, but no JOINTS_0 and WEIGHTS_0",
                         gltf->where);
      goto done;
    }
    TRY(joints_add(blends, sums, gltf, joints, weights, count, pose));
  }
  for (uint32_t i = 0; i < count; i++) {
    if (sums[i] == 0) continue;  // bound to nothing: stays in its bind pose
    for (int e = 0; e < 16; e++) blends[i].m[e] /= sums[i];
    vertex_move(primitive, i, &blends[i]);
  }

done:
  free(blends);
  free(sums);
  return status;
}

Status gltf_pose_apply(Primitive *primitive, Gltf *gltf, const GltfPrimitive *from, const GltfPose *pose)
{
  Status status = STATUS_OK;
  if (from->target_count == 0 && !pose->world_from_bind) return STATUS_OK;
  TRY(morph_apply(primitive, gltf, from, pose));
  if (pose->world_from_bind) TRY(skin_apply(primitive, gltf, from, pose));
  for (uint32_t i = 0; i < primitive->vertex_count; i++)
    if (!vec3_is_finite(vec3_from_floats(primitive->positions[i])))
      return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s: vertex %u is not finite in its pose", gltf->where,
                       i);

done:
  return status;
}

#include "support/gltf_raw.h"

#include <libgen.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct RawNode {
  double translation[3], rotation[4], scale[3], matrix[16];
  int parent;
} RawNode;

struct GltfRawPose {
  size_t vertex_count, joint_count, target_count, node;
  double *positions, *joints, *joint_weights, *inverse_binds;
  double *targets[8], target_weights[8];
  double (*worlds)[16];      // column-major, of all nodes
  double (*joint_from)[16];  // bind pose to world, one a joint; NULL without skin
};

static uint8_t *file_load(const char *path)
{
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  fseek(file, 0, SEEK_END);
  long size = ftell(file);
  rewind(file);
  uint8_t *bytes = malloc((size_t)size + 1);
  assert_int_equal(fread(bytes, 1, (size_t)size, file), (size_t)size);
  bytes[size] = 0;
  fclose(file);
  return bytes;
}

static json_t *at(const json_t *array, size_t index)
{
  json_t *element = json_array_get(array, index);
  assert_non_null(element);
  return element;
}

static json_t *list_at(const GltfRaw *raw, const char *list, size_t index)
{
  return at(json_object_get(raw->json, list), index);
}

static size_t integer(const json_t *object, const char *name)
{
  return (size_t)json_integer_value(json_object_get(object, name));
}

GltfRaw gltf_raw_open(const char *path)
{
  GltfRaw raw = {.file = file_load(path)};
  uint32_t length;
  json_error_t error;
  if (memcmp(raw.file, "glTF", 4) == 0) {
    memcpy(&length, raw.file + 12, sizeof length);
    raw.json = json_loadb((char *)raw.file + 20, length, 0, &error);
    raw.bin = raw.file + 28 + length;
  } else {
    char folder[512], beside[1024];
    raw.json = json_loads((char *)raw.file, 0, &error);
    snprintf(folder, sizeof folder, "%s", path);
    snprintf(beside, sizeof beside, "%s/%s", dirname(folder),
             json_string_value(json_object_get(list_at(&raw, "buffers", 0), "uri")));
    free(raw.file);
    raw.file = raw.bin = file_load(beside);
  }
  assert_non_null(raw.json);
  return raw;
}

void gltf_raw_close(GltfRaw *raw)
{
  json_decref(raw->json);
  free(raw->file);
}

static double number_at(const uint8_t *bytes, size_t type, bool normalized)
{
  float f32;
  int16_t s16;
  uint16_t u16;
  uint32_t u32;
  switch (type) {
    case 5120: return normalized ? fmax((int8_t)*bytes / 127.0, -1) : (int8_t)*bytes;
    case 5121: return *bytes / (normalized ? 255.0 : 1);
    case 5122: memcpy(&s16, bytes, 2); return normalized ? fmax(s16 / 32767.0, -1) : s16;
    case 5123: memcpy(&u16, bytes, 2); return u16 / (normalized ? 65535.0 : 1);
    case 5125: memcpy(&u32, bytes, 4); return u32;
    default: memcpy(&f32, bytes, 4); return (double)f32;
  }
}

double *gltf_raw_numbers(const GltfRaw *raw, size_t accessor, size_t *count, size_t *width)
{
  const json_t *from = list_at(raw, "accessors", accessor);
  const json_t *view = list_at(raw, "bufferViews", integer(from, "bufferView"));
  const char *kind = json_string_value(json_object_get(from, "type"));
  size_t type = integer(from, "componentType"), bytes = type < 5122 ? 1 : type < 5125 ? 2 : 4;
  *count = integer(from, "count");
  *width = kind[0] == 'S' ? 1 : kind[0] == 'M' ? 16 : (size_t)(kind[3] - '0');
  size_t stride = integer(view, "byteStride") ? integer(view, "byteStride") : *width * bytes;
  const uint8_t *first = raw->bin + integer(view, "byteOffset") + integer(from, "byteOffset");
  double *numbers = malloc(*count * *width * sizeof *numbers);
  for (size_t i = 0; i < *count; i++)
    for (size_t c = 0; c < *width; c++)
      numbers[i * *width + c] =
          number_at(first + i * stride + c * bytes, type, json_is_true(json_object_get(from, "normalized")));
  return numbers;
}

// ---- matrices and quaternions, as the text-books have them ---------------------------------------------------------

static void multiply(double out[16], const double a[16], const double b[16])
{
  double product[16] = {0};
  for (int column = 0; column < 4; column++)
    for (int row = 0; row < 4; row++)
      for (int k = 0; k < 4; k++) product[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  memcpy(out, product, sizeof product);
}

static void quaternion_product(double out[4], const double a[4], const double b[4])
{
  double product[4] = {
      a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
      a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
  memcpy(out, product, sizeof product);
}

// `a`, then the share u of the turn that takes it to `b`: by axis and angle of that turn.
static void quaternion_between(double out[4], const double a[4], const double b[4], double u)
{
  double back[4] = {-a[0], -a[1], -a[2], a[3]}, turn[4], part[4];
  quaternion_product(turn, back, b);
  if (turn[3] < 0)
    for (int c = 0; c < 4; c++) turn[c] = -turn[c];
  double sine = sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]), half = atan2(sine, turn[3]);
  for (int c = 0; c < 3; c++) part[c] = sine > 0 ? turn[c] / sine * sin(u * half) : 0;
  part[3] = cos(u * half);
  quaternion_product(out, a, part);
}

static void node_matrix(double out[16], const RawNode *node)
{
  const double *q = node->rotation, *s = node->scale;
  double n = 1 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  double x = q[0] * n, y = q[1] * n, z = q[2] * n, w = q[3] * n;
  const double translate[16] = {
      1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, node->translation[0], node->translation[1], node->translation[2], 1};
  const double rotate[16] = {w * w + x * x - y * y - z * z,
                             2 * x * y + 2 * w * z,
                             2 * x * z - 2 * w * y,
                             0,
                             2 * x * y - 2 * w * z,
                             w * w - x * x + y * y - z * z,
                             2 * y * z + 2 * w * x,
                             0,
                             2 * x * z + 2 * w * y,
                             2 * y * z - 2 * w * x,
                             w * w - x * x - y * y + z * z,
                             0,
                             0,
                             0,
                             0,
                             1};
  const double stretch[16] = {s[0], 0, 0, 0, 0, s[1], 0, 0, 0, 0, s[2], 0, 0, 0, 0, 1};
  multiply(out, rotate, stretch);
  multiply(out, translate, out);
  multiply(out, out, node->matrix);
}

// ---- the pose ------------------------------------------------------------------------------------------------------

static void numbers_copy(double *out, const json_t *object, const char *name)
{
  const json_t *array = json_object_get(object, name);
  for (size_t i = 0; i < json_array_size(array); i++) out[i] = json_number_value(at(array, i));
}

static RawNode *nodes_read(const GltfRaw *raw)
{
  const json_t *list = json_object_get(raw->json, "nodes");
  RawNode *nodes = calloc(json_array_size(list), sizeof *nodes);
  for (size_t i = 0; i < json_array_size(list); i++) nodes[i].parent = -1;
  for (size_t i = 0; i < json_array_size(list); i++) {
    const json_t *children = json_object_get(at(list, i), "children");
    nodes[i].rotation[3] = nodes[i].scale[0] = nodes[i].scale[1] = nodes[i].scale[2] = 1;
    for (int k = 0; k < 4; k++) nodes[i].matrix[5 * k] = 1;
    numbers_copy(nodes[i].translation, at(list, i), "translation");
    numbers_copy(nodes[i].rotation, at(list, i), "rotation");
    numbers_copy(nodes[i].scale, at(list, i), "scale");
    numbers_copy(nodes[i].matrix, at(list, i), "matrix");
    for (size_t k = 0; k < json_array_size(children); k++) nodes[json_integer_value(at(children, k))].parent = (int)i;
  }
  return nodes;
}

// Linear or stepped, and on the sphere for rotations.
static void channel_apply(double *out, const GltfRaw *raw, const json_t *sampler, double time_s, size_t width,
                          bool is_rotation)
{
  size_t keys, values, one, components, k = 0;
  double *times = gltf_raw_numbers(raw, integer(sampler, "input"), &keys, &one);
  double *numbers = gltf_raw_numbers(raw, integer(sampler, "output"), &values, &components);
  const char *interpolation = json_string_value(json_object_get(sampler, "interpolation"));
  while (k + 1 < keys && times[k + 1] <= time_s) k++;
  double u = k + 1 == keys || time_s < times[k] ? 0 : (time_s - times[k]) / (times[k + 1] - times[k]);
  if (interpolation && strcmp(interpolation, "STEP") == 0) u = 0;
  assert_true(!interpolation || strcmp(interpolation, "CUBICSPLINE") != 0);
  assert_int_equal(values * components, keys * width);
  const double *a = numbers + k * width, *b = u > 0 ? a + width : a;
  for (size_t c = 0; c < width; c++) out[c] = (1 - u) * a[c] + u * b[c];
  if (is_rotation) quaternion_between(out, a, b, u);
  free(times);
  free(numbers);
}

static void animation_apply(RawNode *nodes, GltfRawPose *pose, const GltfRaw *raw, size_t animation, double time_s)
{
  const json_t *from = list_at(raw, "animations", animation), *channels = json_object_get(from, "channels");
  for (size_t i = 0; i < json_array_size(channels); i++) {
    const json_t *target = json_object_get(at(channels, i), "target");
    const json_t *sampler = at(json_object_get(from, "samplers"), integer(at(channels, i), "sampler"));
    const char *path = json_string_value(json_object_get(target, "path"));
    RawNode *node = &nodes[integer(target, "node")];
    if (strcmp(path, "translation") == 0) channel_apply(node->translation, raw, sampler, time_s, 3, false);
    if (strcmp(path, "rotation") == 0) channel_apply(node->rotation, raw, sampler, time_s, 4, true);
    if (strcmp(path, "scale") == 0) channel_apply(node->scale, raw, sampler, time_s, 3, false);
    if (strcmp(path, "weights") == 0 && integer(target, "node") == pose->node)
      channel_apply(pose->target_weights, raw, sampler, time_s, pose->target_count, false);
  }
}

static void worlds_make(GltfRawPose *pose, const GltfRaw *raw, const RawNode *nodes)
{
  size_t count = json_array_size(json_object_get(raw->json, "nodes"));
  pose->worlds = calloc(count, sizeof *pose->worlds);
  for (size_t i = 0; i < count; i++) {
    double step[16];
    node_matrix(pose->worlds[i], &nodes[i]);
    for (int up = nodes[i].parent; up >= 0; up = nodes[up].parent) {
      node_matrix(step, &nodes[up]);
      multiply(pose->worlds[i], step, pose->worlds[i]);
    }
  }
}

static void skin_read(GltfRawPose *pose, const GltfRaw *raw, const json_t *skin, const json_t *attributes)
{
  const json_t *joints = json_object_get(skin, "joints");
  size_t count, width;
  pose->joint_count = json_array_size(joints);
  pose->joints = gltf_raw_numbers(raw, integer(attributes, "JOINTS_0"), &count, &width);
  pose->joint_weights = gltf_raw_numbers(raw, integer(attributes, "WEIGHTS_0"), &count, &width);
  pose->inverse_binds = gltf_raw_numbers(raw, integer(skin, "inverseBindMatrices"), &count, &width);
  pose->joint_from = calloc(pose->joint_count, sizeof *pose->joint_from);
  for (size_t i = 0; i < pose->joint_count; i++)
    multiply(pose->joint_from[i], pose->worlds[json_integer_value(at(joints, i))], pose->inverse_binds + 16 * i);
}

GltfRawPose *gltf_raw_pose(const GltfRaw *raw, size_t animation, double time_s, size_t node)
{
  GltfRawPose *pose = calloc(1, sizeof *pose);
  const json_t *from = list_at(raw, "nodes", node), *mesh = list_at(raw, "meshes", integer(from, "mesh"));
  const json_t *primitive = at(json_object_get(mesh, "primitives"), 0),
               *targets = json_object_get(primitive, "targets");
  const json_t *attributes = json_object_get(primitive, "attributes");
  size_t count, width;
  RawNode *nodes = nodes_read(raw);
  pose->node = node;
  pose->positions = gltf_raw_numbers(raw, integer(attributes, "POSITION"), &pose->vertex_count, &width);
  pose->target_count = json_array_size(targets);
  assert_true(pose->target_count <= 8);
  for (size_t i = 0; i < pose->target_count; i++)
    pose->targets[i] = gltf_raw_numbers(raw, integer(at(targets, i), "POSITION"), &count, &width);
  numbers_copy(pose->target_weights, mesh, "weights");
  animation_apply(nodes, pose, raw, animation, time_s);
  worlds_make(pose, raw, nodes);
  if (json_object_get(from, "skin")) skin_read(pose, raw, list_at(raw, "skins", integer(from, "skin")), attributes);
  free(nodes);
  return pose;
}

size_t gltf_raw_vertex_count(const GltfRawPose *pose) { return pose->vertex_count; }

static void point_add(double out[3], const double matrix[16], const double point[3], double weight)
{
  for (int row = 0; row < 3; row++)
    out[row] +=
        weight * (matrix[row] * point[0] + matrix[4 + row] * point[1] + matrix[8 + row] * point[2] + matrix[12 + row]);
}

void gltf_raw_vertex(double out[3], const GltfRawPose *pose, size_t vertex)
{
  double point[3], sum = 0;
  for (int c = 0; c < 3; c++) {
    out[c] = 0;
    point[c] = pose->positions[3 * vertex + (size_t)c];
    for (size_t i = 0; i < pose->target_count; i++)
      point[c] += pose->target_weights[i] * pose->targets[i][3 * vertex + (size_t)c];
  }
  if (!pose->joint_from) {
    point_add(out, pose->worlds[pose->node], point, 1);
    return;
  }
  const double *joints = pose->joints + 4 * vertex, *weights = pose->joint_weights + 4 * vertex;
  for (int k = 0; k < 4; k++) sum += weights[k];
  for (int k = 0; k < 4; k++) point_add(out, pose->joint_from[(size_t)joints[k]], point, weights[k] / sum);
}

void gltf_raw_pose_free(GltfRawPose *pose)
{
  for (size_t i = 0; i < pose->target_count; i++) free(pose->targets[i]);
  free(pose->positions);
  free(pose->joints);
  free(pose->joint_weights);
  free(pose->inverse_binds);
  free(pose->worlds);
  free(pose->joint_from);
  free(pose);
}

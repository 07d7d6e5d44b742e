// What glTF 2.0's schema says, as far as tinygltf and the importer rely on it: one row a property.
#include <stdio.h>
#include <string.h>

#include "scene/gltf_json.h"

typedef enum RuleKind {
  RULE_INDEX,    // integer below the length of the root array `into`
  RULE_UINT,     // integer from 0 to 2^53
  RULE_NUMBER,   // a number
  RULE_NUMBERS,  // array of `length` numbers, or of any length where that is 0
  RULE_STRING,   // one of the words of `into`, where it is not NULL
  RULE_BOOLEAN,
  RULE_OBJECT,
} RuleKind;

typedef struct Rule {
  const char *path;  // `[]` every element of an array, `{}` every member of an object
  RuleKind kind;
  const char *into;
  uint32_t length;
  bool required;
} Rule;

#define RULE(path_, kind_, ...)                      \
  {                                                  \
    .path = path_, .kind = RULE_##kind_, __VA_ARGS__ \
  }

static const Rule rules[] = {
    RULE("accessors[]", OBJECT),
    RULE("bufferViews[]", OBJECT),
    RULE("buffers[]", OBJECT),
    RULE("cameras[]", OBJECT),
    RULE("images[]", OBJECT),
    RULE("materials[]", OBJECT),
    RULE("meshes[]", OBJECT),
    RULE("nodes[]", OBJECT),
    RULE("samplers[]", OBJECT),
    RULE("scenes[]", OBJECT),
    RULE("skins[]", OBJECT),
    RULE("textures[]", OBJECT),
    RULE("animations[]", OBJECT),
    RULE("extensionsUsed[]", STRING),
    RULE("extensionsRequired[]", STRING),
    RULE("scene", INDEX, .into = "scenes"),

    RULE("buffers[].byteLength", UINT, .required = true),
    RULE("buffers[].uri", STRING),
    RULE("bufferViews[].buffer", INDEX, .into = "buffers", .required = true),
    RULE("bufferViews[].byteOffset", UINT),
    RULE("bufferViews[].byteLength", UINT, .required = true),
    RULE("bufferViews[].byteStride", UINT),
    RULE("accessors[].bufferView", INDEX, .into = "bufferViews"),
    RULE("accessors[].byteOffset", UINT),
    RULE("accessors[].componentType", UINT, .required = true),
    RULE("accessors[].normalized", BOOLEAN),
    RULE("accessors[].count", UINT, .required = true),
    RULE("accessors[].type", STRING, .into = "SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4", .required = true),
    RULE("accessors[].sparse", OBJECT),
    RULE("accessors[].sparse.count", UINT, .required = true),
    RULE("accessors[].sparse.indices", OBJECT, .required = true),
    RULE("accessors[].sparse.indices.bufferView", INDEX, .into = "bufferViews", .required = true),
    RULE("accessors[].sparse.indices.byteOffset", UINT),
    RULE("accessors[].sparse.indices.componentType", UINT, .required = true),
    RULE("accessors[].sparse.values", OBJECT, .required = true),
    RULE("accessors[].sparse.values.bufferView", INDEX, .into = "bufferViews", .required = true),
    RULE("accessors[].sparse.values.byteOffset", UINT),

    RULE("meshes[].name", STRING),
    RULE("meshes[].weights", NUMBERS),
    RULE("meshes[].primitives[]", OBJECT),
    RULE("meshes[].primitives[].mode", UINT),
    RULE("meshes[].primitives[].indices", INDEX, .into = "accessors"),
    RULE("meshes[].primitives[].material", INDEX, .into = "materials"),
    RULE("meshes[].primitives[].attributes", OBJECT, .required = true),
    RULE("meshes[].primitives[].attributes{}", INDEX, .into = "accessors"),
    RULE("meshes[].primitives[].targets[]", OBJECT),
    RULE("meshes[].primitives[].targets[]{}", INDEX, .into = "accessors"),

    RULE("nodes[].name", STRING),
    RULE("nodes[].mesh", INDEX, .into = "meshes"),
    RULE("nodes[].skin", INDEX, .into = "skins"),
    RULE("nodes[].camera", INDEX, .into = "cameras"),
    RULE("nodes[].children[]", INDEX, .into = "nodes"),
    RULE("nodes[].matrix", NUMBERS, .length = 16),
    RULE("nodes[].translation", NUMBERS, .length = 3),
    RULE("nodes[].rotation", NUMBERS, .length = 4),
    RULE("nodes[].scale", NUMBERS, .length = 3),
    RULE("nodes[].weights", NUMBERS),
    RULE("nodes[].extensions.KHR_lights_punctual.light", INDEX, .into = "lights", .required = true),
    RULE("nodes[].extensions.EXT_mesh_gpu_instancing.attributes", OBJECT, .required = true),
    RULE("nodes[].extensions.EXT_mesh_gpu_instancing.attributes{}", INDEX, .into = "accessors"),
    RULE("scenes[].nodes[]", INDEX, .into = "nodes"),
    RULE("skins[].joints", NUMBERS, .required = true),
    RULE("skins[].joints[]", INDEX, .into = "nodes"),
    RULE("skins[].inverseBindMatrices", INDEX, .into = "accessors"),

    RULE("animations[].name", STRING),
    RULE("animations[].samplers[]", OBJECT),
    RULE("animations[].samplers[].input", INDEX, .into = "accessors", .required = true),
    RULE("animations[].samplers[].output", INDEX, .into = "accessors", .required = true),
    RULE("animations[].samplers[].interpolation", STRING, .into = "LINEAR STEP CUBICSPLINE"),
    RULE("animations[].channels[]", OBJECT),
    RULE("animations[].channels[].sampler", UINT, .required = true),
    RULE("animations[].channels[].target", OBJECT, .required = true),
    RULE("animations[].channels[].target.node", INDEX, .into = "nodes"),
    RULE("animations[].channels[].target.path", STRING, .required = true),

    RULE("images[].uri", STRING),
    RULE("images[].bufferView", INDEX, .into = "bufferViews"),
    RULE("textures[].source", INDEX, .into = "images"),
    RULE("textures[].sampler", INDEX, .into = "samplers"),
    RULE("samplers[].magFilter", UINT),
    RULE("samplers[].wrapS", UINT),
    RULE("samplers[].wrapT", UINT),
    RULE("materials[].name", STRING),
    RULE("materials[].emissiveFactor", NUMBERS, .length = 3),
    RULE("materials[].alphaMode", STRING, .into = "OPAQUE MASK BLEND"),
    RULE("materials[].alphaCutoff", NUMBER),
    RULE("materials[].doubleSided", BOOLEAN),
    RULE("materials[].pbrMetallicRoughness", OBJECT),
    RULE("materials[].pbrMetallicRoughness.baseColorFactor", NUMBERS, .length = 4),
    RULE("materials[].pbrMetallicRoughness.metallicFactor", NUMBER),
    RULE("materials[].pbrMetallicRoughness.roughnessFactor", NUMBER),
    RULE("materials[].pbrMetallicRoughness.baseColorTexture.index", INDEX, .into = "textures", .required = true),
    RULE("materials[].pbrMetallicRoughness.baseColorTexture.texCoord", UINT),
    RULE("materials[].pbrMetallicRoughness.metallicRoughnessTexture.index", INDEX, .into = "textures",
         .required = true),
    RULE("materials[].pbrMetallicRoughness.metallicRoughnessTexture.texCoord", UINT),
    RULE("materials[].normalTexture.index", INDEX, .into = "textures", .required = true),
    RULE("materials[].normalTexture.texCoord", UINT),
    RULE("materials[].normalTexture.scale", NUMBER),
    RULE("materials[].occlusionTexture.index", INDEX, .into = "textures", .required = true),
    RULE("materials[].occlusionTexture.texCoord", UINT),
    RULE("materials[].occlusionTexture.strength", NUMBER),
    RULE("materials[].emissiveTexture.index", INDEX, .into = "textures", .required = true),
    RULE("materials[].emissiveTexture.texCoord", UINT),

    RULE("cameras[].name", STRING),
    RULE("cameras[].type", STRING, .into = "perspective orthographic", .required = true),
    RULE("cameras[].perspective.yfov", NUMBER, .required = true),
    RULE("cameras[].perspective.znear", NUMBER, .required = true),
    RULE("cameras[].perspective.zfar", NUMBER),
    RULE("cameras[].orthographic.ymag", NUMBER, .required = true),
    RULE("cameras[].orthographic.znear", NUMBER, .required = true),
    RULE("cameras[].orthographic.zfar", NUMBER, .required = true),
    RULE("extensions.KHR_lights_punctual.lights[]", OBJECT),
    RULE("extensions.KHR_lights_punctual.lights[].name", STRING),
    RULE("extensions.KHR_lights_punctual.lights[].type", STRING, .into = "directional point spot", .required = true),
    RULE("extensions.KHR_lights_punctual.lights[].color", NUMBERS, .length = 3),
    RULE("extensions.KHR_lights_punctual.lights[].intensity", NUMBER),
    RULE("extensions.KHR_lights_punctual.lights[].range", NUMBER),
    RULE("extensions.KHR_lights_punctual.lights[].spot", OBJECT),
};

typedef struct Walk {
  Gltf *gltf;
  const Rule *rule;
  uint64_t limit;  // RULE_INDEX: length of the array pointed into
  char where[256];
} Walk;

static Status walk_fail(Walk *walk, const char *cause)
{
  return gltf_fail(walk->gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s %s", walk->where, cause);
}

static bool is_word_of(const char *word, const char *words)
{
  size_t length = strlen(word);
  for (const char *at = words; length > 0 && (at = strstr(at, word)); at += length)
    if ((at == words || at[-1] == ' ') && (at[length] == ' ' || at[length] == 0)) return true;
  return false;
}

static Status numbers_check(Walk *walk, const json_t *value)
{
  size_t i;
  json_t *number;
  char cause[64];
  snprintf(cause, sizeof cause, "is not an array of %u numbers", walk->rule->length);
  if (walk->rule->length == 0) snprintf(cause, sizeof cause, "is not an array of numbers");
  if (!json_is_array(value) || (walk->rule->length && json_array_size(value) != walk->rule->length))
    return walk_fail(walk, cause);
  json_array_foreach(value, i, number)
  {
    if (!json_is_number(number)) return walk_fail(walk, cause);
  }
  return STATUS_OK;
}

static Status value_check(Walk *walk, const json_t *value)
{
  const Rule *rule = walk->rule;
  json_int_t integer = json_integer_value(value);
  switch (rule->kind) {
    case RULE_INDEX:
      if (!json_is_integer(value)) return walk_fail(walk, "is not an index");
      if (integer < 0 || (uint64_t)integer >= walk->limit)
        return gltf_fail(walk->gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s is %lld, but the file has %llu %s",
                         walk->where, (long long)integer, (unsigned long long)walk->limit, rule->into);
      return STATUS_OK;
    case RULE_UINT:
      if (!json_is_integer(value) || integer < 0 || integer > (1LL << 53)) return walk_fail(walk, "is not a size");
      return STATUS_OK;
    case RULE_NUMBER: return json_is_number(value) ? STATUS_OK : walk_fail(walk, "is not a number");
    case RULE_NUMBERS: return numbers_check(walk, value);
    case RULE_STRING:
      if (!json_is_string(value)) return walk_fail(walk, "is not a string");
      if (rule->into && !is_word_of(json_string_value(value), rule->into))
        return gltf_fail(walk->gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s is '%.32s', not one of: %s", walk->where,
                         json_string_value(value), rule->into);
      return STATUS_OK;
    case RULE_BOOLEAN: return json_is_boolean(value) ? STATUS_OK : walk_fail(walk, "is neither true nor false");
    case RULE_OBJECT: return json_is_object(value) ? STATUS_OK : walk_fail(walk, "is not an object");
  }
  return STATUS_OK;
}

// Follows the rest of a path from `at`; `length` is how much of walk->where names `at`.
static Status walk_path(Walk *walk, json_t *at, const char *path, size_t length)
{
  Status status = STATUS_OK;
  char *where = walk->where + length;
  size_t room = sizeof walk->where - length, i;
  json_t *child;
  const char *key;
  *where = 0;
  if (*path == 0) return value_check(walk, at);
  if (strncmp(path, "[]", 2) == 0) {
    if (!json_is_array(at)) return walk_fail(walk, "is not an array");
    json_array_foreach(at, i, child)
    {
      int wrote = snprintf(where, room, "[%zu]", i);
      TRY(walk_path(walk, child, path + 2, length + (size_t)wrote));
    }
  } else if (strncmp(path, "{}", 2) == 0) {
    if (!json_is_object(at)) return walk_fail(walk, "is not an object");
    json_object_foreach(at, key, child)
    {
      int wrote = snprintf(where, room, ".%.32s", key);
      TRY(walk_path(walk, child, path + 2, length + (size_t)wrote));
    }
  } else {
    if (*path == '.') path++;
    char name[64];
    size_t size = strcspn(path, ".[{");
    snprintf(name, sizeof name, "%.*s", (int)size, path);
    if (!json_is_object(at)) return walk_fail(walk, "is not an object");
    int wrote = snprintf(where, room, "%s%s", length ? "." : "", name);
    child = json_object_get(at, name);
    if (child) return walk_path(walk, child, path + size, length + (size_t)wrote);
    if (walk->rule->required && path[size] == 0) return walk_fail(walk, "is missing");
  }

done:
  return status;
}

// Channels name samplers of their own animation.
static Status samplers_check(Gltf *gltf)
{
  size_t a, c;
  json_t *animation, *channel;
  json_array_foreach(json_object_get(gltf->document, "animations"), a, animation)
  {
    uint64_t count = json_array_size(json_object_get(animation, "samplers"));
    json_array_foreach(json_object_get(animation, "channels"), c, channel)
    {
      uint64_t sampler = gltf_json_uint(channel, "sampler", 0);
      if (sampler >= count)
        return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR,
                         "animations[%zu].channels[%zu].sampler is %llu, but the animation has %llu samplers", a, c,
                         (unsigned long long)sampler, (unsigned long long)count);
    }
  }
  return STATUS_OK;
}

Status gltf_json_check_rules(Gltf *gltf)
{
  Status status = STATUS_OK;
  const json_t *lights =
      json_object_get(json_object_get(json_object_get(gltf->document, "extensions"), "KHR_lights_punctual"), "lights");
  for (size_t i = 0; i < sizeof rules / sizeof *rules; i++) {
    const Rule *rule = &rules[i];
    Walk walk = {.gltf = gltf, .rule = rule};
    if (rule->kind == RULE_INDEX)
      walk.limit =
          json_array_size(strcmp(rule->into, "lights") == 0 ? lights : json_object_get(gltf->document, rule->into));
    TRY(walk_path(&walk, gltf->document, rule->path, 0));
  }
  TRY(samplers_check(gltf));

done:
  return status;
}

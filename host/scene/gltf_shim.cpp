#include <tiny_gltf.h>

#include <deque>
#include <exception>

extern "C" {
#include "scene/gltf_context.h"
#include "scene/gltf_shim.h"
}

namespace
{

// Owns tinygltf's model and the arrays made of it; the C structs point into both.
struct Owner : GltfModel {
  tinygltf::Model source;
  std::vector<GltfView> view_store;
  std::vector<GltfAccessor> accessor_store;
  std::vector<GltfMesh> mesh_store;
  std::deque<std::vector<GltfPrimitive>> primitive_store;
  std::deque<std::vector<std::array<int, ATTRIBUTE_TANGENT + 1>>> target_store;
  std::vector<GltfNode> node_store;
  std::vector<GltfSkin> skin_store;
  std::vector<GltfTexture> texture_store;
  std::vector<GltfScene> scene_store;
  std::vector<Material> material_store;
  std::vector<Camera> camera_store;
  std::vector<Light> light_store;

  Owner() : GltfModel{} {}
};

const char *const attribute_names[ATTRIBUTE_COUNT] = {"POSITION", "NORMAL",   "TANGENT",  "TEXCOORD_0", "TEXCOORD_1",
                                                      "COLOR_0",  "JOINTS_0", "JOINTS_1", "WEIGHTS_0",  "WEIGHTS_1"};

char *name_of(const std::string &name) { return const_cast<char *>(name.c_str()); }

int index_or_none(const std::map<std::string, int> &from, const char *name)
{
  auto found = from.find(name);
  return found == from.end() ? NONE : found->second;
}

const tinygltf::Value *extension(const tinygltf::ExtensionMap &from, const char *name)
{
  auto found = from.find(name);
  return found == from.end() ? nullptr : &found->second;
}

double number_or(const tinygltf::Value &from, const char *name, double fallback)
{
  return from.Has(name) && from.Get(name).IsNumber() ? from.Get(name).GetNumberAsDouble() : fallback;
}

int integer_or_none(const tinygltf::Value &from, const char *name) { return (int)number_or(from, name, NONE); }

double element_or(const tinygltf::Value &from, const char *name, int i, double fallback)
{
  return from.Has(name) && from.Get(name).IsArray() && (size_t)i < from.Get(name).ArrayLen()
             ? from.Get(name).Get(i).GetNumberAsDouble()
             : fallback;
}

template <typename Target>
void copy_numbers(Target *target, const std::vector<double> &from, size_t count)
{
  for (size_t i = 0; from.size() == count && i < count; i++) target[i] = (Target)from[i];
}

template <typename Info>
TextureSlot texture_slot(const Info &from)
{
  TextureSlot slot = {from.index, (uint32_t)from.texCoord, {1, 0, 0, 0, 1, 0}};
  const tinygltf::Value *transform = extension(from.extensions, "KHR_texture_transform");
  if (!transform) return slot;
  double angle = number_or(*transform, "rotation", 0), c = std::cos(angle), s = std::sin(angle);
  double sx = element_or(*transform, "scale", 0, 1), sy = element_or(*transform, "scale", 1, 1);
  slot.uv_set = (uint32_t)std::fmin(std::fmax(number_or(*transform, "texCoord", from.texCoord), 0), 99);
  const double matrix[6] = {c * sx,  s * sy, element_or(*transform, "offset", 0, 0),
                            -s * sx, c * sy, element_or(*transform, "offset", 1, 0)};
  for (int i = 0; i < 6; i++) slot.uv_from_uv[i] = (float)matrix[i];
  return slot;
}

Material material_of(const tinygltf::Material &from)
{
  const tinygltf::PbrMetallicRoughness &pbr = from.pbrMetallicRoughness;
  const tinygltf::Value *strength = extension(from.extensions, "KHR_materials_emissive_strength");
  Material material = {};
  material.name = name_of(from.name);
  copy_numbers(material.base_color, pbr.baseColorFactor, 4);
  material.metallic = (float)pbr.metallicFactor;
  material.roughness = (float)pbr.roughnessFactor;
  copy_numbers(material.emission, from.emissiveFactor, 3);
  for (float &e : material.emission) e *= strength ? (float)number_or(*strength, "emissiveStrength", 1) : 1;
  material.alpha_mode = from.alphaMode == "MASK" ? ALPHA_MASK : from.alphaMode == "BLEND" ? ALPHA_BLEND : ALPHA_OPAQUE;
  material.alpha_cutoff = (float)from.alphaCutoff;
  material.double_sided = from.doubleSided;
  material.unlit = extension(from.extensions, "KHR_materials_unlit") != nullptr;
  material.normal_scale = (float)from.normalTexture.scale;
  material.occlusion_strength = (float)from.occlusionTexture.strength;
  material.base_color_slot = texture_slot(pbr.baseColorTexture);
  material.metallic_roughness_slot = texture_slot(pbr.metallicRoughnessTexture);
  material.emission_slot = texture_slot(from.emissiveTexture);
  material.normal_slot = texture_slot(from.normalTexture);
  material.occlusion_slot = texture_slot(from.occlusionTexture);
  return material;
}

WrapMode wrap_of(int code)
{
  return code == WRAP_GL_CLAMP ? WRAP_CLAMP : code == WRAP_GL_MIRROR ? WRAP_MIRROR : WRAP_REPEAT;
}

GltfTexture texture_of(const tinygltf::Texture &from, const tinygltf::Model &source)
{
  tinygltf::Sampler sampler;
  if (from.sampler >= 0) sampler = source.samplers[(size_t)from.sampler];
  return {from.source, wrap_of(sampler.wrapS), wrap_of(sampler.wrapT), sampler.magFilter == FILTER_NEAREST};
}

GltfAccessor accessor_of(const tinygltf::Accessor &from)
{
  GltfAccessor accessor = {};
  accessor.values = {from.bufferView, from.byteOffset, from.componentType};
  accessor.count = from.count;
  accessor.components = (uint32_t)tinygltf::GetNumComponentsInType((uint32_t)from.type);
  accessor.is_matrix =
      from.type == TINYGLTF_TYPE_MAT2 || from.type == TINYGLTF_TYPE_MAT3 || from.type == TINYGLTF_TYPE_MAT4;
  accessor.normalized = from.normalized;
  if (!from.sparse.isSparse) return accessor;
  accessor.sparse_count = (uint64_t)from.sparse.count;
  accessor.sparse_indices = {from.sparse.indices.bufferView, (uint64_t)from.sparse.indices.byteOffset,
                             from.sparse.indices.componentType};
  accessor.sparse_values = {from.sparse.values.bufferView, (uint64_t)from.sparse.values.byteOffset, from.componentType};
  return accessor;
}

GltfPrimitive primitive_of(Owner *owner, const tinygltf::Primitive &from)
{
  GltfPrimitive primitive = {};
  primitive.mode = from.mode;
  primitive.material = from.material;
  primitive.indices = from.indices;
  for (int i = 0; i < ATTRIBUTE_COUNT; i++)
    primitive.attributes[i] = index_or_none(from.attributes, attribute_names[i]);
  owner->target_store.emplace_back();
  for (const auto &target : from.targets)
    owner->target_store.back().push_back(
        {index_or_none(target, "POSITION"), index_or_none(target, "NORMAL"), index_or_none(target, "TANGENT")});
  primitive.targets = reinterpret_cast<const int(*)[ATTRIBUTE_TANGENT + 1]>(owner->target_store.back().data());
  primitive.target_count = (uint32_t)from.targets.size();
  return primitive;
}

GltfMesh mesh_of(Owner *owner, const tinygltf::Mesh &from)
{
  owner->primitive_store.emplace_back();
  for (const auto &primitive : from.primitives) owner->primitive_store.back().push_back(primitive_of(owner, primitive));
  const auto &primitives = owner->primitive_store.back();
  return {from.name.c_str(), primitives.data(), (uint32_t)primitives.size(), from.weights.data(),
          (uint32_t)from.weights.size()};
}

GltfNode node_of(const tinygltf::Node &from)
{
  GltfNode node = {};
  const tinygltf::Value *light = extension(from.extensions, "KHR_lights_punctual");
  const tinygltf::Value *instancing = extension(from.extensions, "EXT_mesh_gpu_instancing");
  node.name = from.name.c_str();
  node.mesh = from.mesh;
  node.skin = from.skin;
  node.camera = from.camera;
  node.light = light ? integer_or_none(*light, "light") : NONE;
  node.children = from.children.data();
  node.child_count = (uint32_t)from.children.size();
  node.matrix = from.matrix.size() == 16 ? from.matrix.data() : nullptr;
  node.rotation[3] = 1;
  for (double &s : node.scale) s = 1;
  copy_numbers(node.translation, from.translation, 3);
  copy_numbers(node.rotation, from.rotation, 4);
  copy_numbers(node.scale, from.scale, 3);
  node.weights = from.weights.empty() ? nullptr : from.weights.data();
  node.weight_count = (uint32_t)from.weights.size();
  node.is_instanced = instancing && instancing->Has("attributes");
  node.instance_translation = node.is_instanced ? integer_or_none(instancing->Get("attributes"), "TRANSLATION") : NONE;
  node.instance_rotation = node.is_instanced ? integer_or_none(instancing->Get("attributes"), "ROTATION") : NONE;
  node.instance_scale = node.is_instanced ? integer_or_none(instancing->Get("attributes"), "SCALE") : NONE;
  return node;
}

Camera camera_of(const tinygltf::Camera &from)
{
  Camera camera = {};
  bool is_perspective = from.type == "perspective";
  camera.name = name_of(from.name);
  camera.kind = is_perspective ? CAMERA_PERSPECTIVE : CAMERA_ORTHOGRAPHIC;
  camera.yfov_rad = from.perspective.yfov;
  camera.ymag_m = from.orthographic.ymag;
  camera.znear_m = is_perspective ? from.perspective.znear : from.orthographic.znear;
  camera.zfar_m = is_perspective ? from.perspective.zfar : from.orthographic.zfar;
  if (is_perspective && camera.zfar_m == 0) camera.zfar_m = INFINITY;
  return camera;
}

Light light_of(const tinygltf::Light &from)
{
  Light light = {};
  light.name = name_of(from.name);
  light.kind = from.type == "directional" ? LIGHT_DIRECTIONAL : from.type == "spot" ? LIGHT_SPOT : LIGHT_POINT;
  for (float &c : light.color) c = 1;
  copy_numbers(light.color, from.color, 3);
  light.intensity = (float)from.intensity;
  light.range_m = from.range > 0 ? from.range : INFINITY;
  light.inner_cone_rad = from.spot.innerConeAngle;
  light.outer_cone_rad = from.spot.outerConeAngle;
  return light;
}

void model_copy(Owner *owner)
{
  const tinygltf::Model &from = owner->source;
  for (const auto &v : from.bufferViews)
    owner->view_store.push_back({v.buffer, v.byteOffset, v.byteLength, (uint32_t)v.byteStride});
  for (const auto &a : from.accessors) owner->accessor_store.push_back(accessor_of(a));
  for (const auto &m : from.meshes) owner->mesh_store.push_back(mesh_of(owner, m));
  for (const auto &n : from.nodes) owner->node_store.push_back(node_of(n));
  for (const auto &s : from.skins)
    owner->skin_store.push_back({s.joints.data(), (uint32_t)s.joints.size(), s.inverseBindMatrices});
  for (const auto &t : from.textures) owner->texture_store.push_back(texture_of(t, from));
  for (const auto &s : from.scenes) owner->scene_store.push_back({s.nodes.data(), (uint32_t)s.nodes.size()});
  for (const auto &m : from.materials) owner->material_store.push_back(material_of(m));
  for (const auto &c : from.cameras) owner->camera_store.push_back(camera_of(c));
  for (const auto &l : from.lights) owner->light_store.push_back(light_of(l));

  owner->views = owner->view_store.data();
  owner->accessors = owner->accessor_store.data();
  owner->meshes = owner->mesh_store.data();
  owner->nodes = owner->node_store.data();
  owner->skins = owner->skin_store.data();
  owner->textures = owner->texture_store.data();
  owner->scenes = owner->scene_store.data();
  owner->materials = owner->material_store.data();
  owner->cameras = owner->camera_store.data();
  owner->lights = owner->light_store.data();
  owner->accessor_count = (uint32_t)from.accessors.size();
  owner->mesh_count = (uint32_t)from.meshes.size();
  owner->node_count = (uint32_t)from.nodes.size();
  owner->texture_count = (uint32_t)from.textures.size();
  owner->scene_count = (uint32_t)from.scenes.size();
  owner->material_count = (uint32_t)from.materials.size();
  owner->animation_count = (uint32_t)from.animations.size();
  owner->default_scene = from.defaultScene;
}

}  // namespace

Status gltf_shim_load(GltfModel **out, const char *json, size_t size, const char *path, Log *log)
{
  Owner *owner = nullptr;
  try {
    owner = new Owner();
    std::string error, warning;
    tinygltf::TinyGLTF loader;
    if (loader.LoadASCIIFromString(&owner->source, &error, &warning, json, (unsigned)size, "")) {
      model_copy(owner);
      *out = owner;
      return STATUS_OK;
    }
    for (char &c : error)
      if (c == '\n') c = ' ';
    log_fail(log, STATUS_BAD_SCENE, "%s: tinygltf refuses it (%s): " GLTF_HINT_REPAIR, path, error.c_str());
  } catch (const std::bad_alloc &) {
    delete owner;
    return log_no_memory(log, path);
  } catch (const std::exception &e) {
    log_fail(log, STATUS_BAD_SCENE, "%s: tinygltf gave up (%s): " GLTF_HINT_REPAIR, path, e.what());
  }
  delete owner;
  return STATUS_BAD_SCENE;
}

void gltf_shim_free(GltfModel *model) { delete static_cast<Owner *>(model); }

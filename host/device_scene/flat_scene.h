// The scene flattened to world-space arrays on the host, before it goes to a device.
#pragma once

#include "base/log.h"
#include "scene/scene.h"
#include "shared/scene.h"

// Triangles are numbered object by object, primitive by primitive, as in the file: that number is a triangle's id.
// A mirrored object's triangles are turned round, so that counter-clockwise is always the front.
typedef struct FlatScene {
  float (*positions)[3];  // [vertex_count], world space
  float (*normals)[3];    // [vertex_count], unit, world space
  Float4 *tangents;  // [vertex_count], w = side of the bitangent, 0 where the file has none; NULL without normal maps
  Float2 *uvs;       // [uv_set_count][vertex_count]
  Float4 *colors;    // [vertex_count], or NULL when no primitive has any
  TriangleCorners *corners;  // [triangle_count]
  uint32_t *flags;           // [triangle_count], TRIANGLE_* of shared/bvh.h
  uint32_t *object_starts;   // [object_count + 1], first triangle of each object
  uint32_t vertex_count, triangle_count, object_count, uv_set_count;

  MaterialInfo *materials;
  TextureInfo *textures;
  uint8_t *texels;  // RGBA of every texture used, one after the other
  uint64_t texel_count;
  LightInfo *lights;
  uint32_t material_count, texture_count, light_count;
  EnvironmentInfo environment;

  bool has_mirrors;         // a material can have roughness 0
  float least_roughness;    // of what is no mirror; INFINITY where there is nothing but mirrors
  bool environment_lights;  // the environment is not black
} FlatScene;

// Flattens a scene. Transforms are applied in double precision and rounded to float once; both cores, about 20 ns a
// vertex. Errors: STATUS_TOO_LARGE (over 2^28 triangles or 2^31 texels), STATUS_NO_MEMORY.
Status flat_scene_make(FlatScene *out, const Scene *scene, Log *log);
void flat_scene_free(FlatScene *flat);

// Forgets what vertices and triangles have, and the texels: others free them now.
void flat_scene_forget(FlatScene *flat);

// Is its shading normal bent by a texture? One that has no texture coordinates is not.
bool primitive_has_normal_map(const Primitive *primitive, const Scene *scene);

typedef struct FlatRange {
  uint32_t begin, end;
} FlatRange;

// Some vertices and some triangles of one primitive of one object; what one thread flattens.
typedef struct FlatPart {
  uint32_t object, primitive;
  uint32_t first_vertex, first_triangle;  // of the primitive, in the flattened scene
  FlatRange vertices, triangles;          // of the part, in the flattened scene
} FlatPart;

// Cuts a scene into parts, in the order of objects; *out is freed by the caller. Errors: STATUS_NO_MEMORY.
Status flat_parts_make(FlatPart **out, uint32_t *count, const Scene *scene, Log *log);

// Writes what of a part may move: positions, normals, tangents and corners.
void flat_part_place(FlatScene *flat, const Scene *scene, const FlatPart *part);

// The parts of it, by file: vertices and triangles; materials, textures and lights; the environment.
Status flat_geometry_make(FlatScene *flat, const Scene *scene, Log *log);
Status flat_materials_make(FlatScene *flat, const Scene *scene, Log *log);
void flat_lights_fill(LightInfo *out, const Scene *scene);  // [light_count]
void flat_environment_make(FlatScene *flat, const Environment *environment);

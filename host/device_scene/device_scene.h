// The scene on a device: flat arrays and the BVH that its class of device walks.
#pragma once

#include "device/device.h"
#include "device_scene/flat_scene.h"

// An object of which a position, normal, tangent or corner changed by a bit. Bounds of where its triangles were and
// are, together, world space; low > high where none of them is finite.
typedef struct Mover {
  uint32_t object;
  Vec3 low, high;
} Mover;

typedef struct KeptScene KeptScene;

typedef struct DeviceScene {
  // by vertex and by triangle (shared/scene.h)
  DeviceBuffer positions, normals, tangents, uvs, colors, corners, object_starts;
  DeviceBuffer materials, textures, texels, linear_from_byte;
  DeviceBuffer lights, environment, environment_pixels;
  // shared/bvh.h; the wide tree is there only where device_traits()->wide_bvh
  DeviceBuffer bvh2_nodes, bvh2_triangles, bvh8_nodes, bvh8_blocks;

  LightInfo *light_infos;  // [light_count], the host's copy of `lights`
  Vec3 low, high;          // bounds, world space; zero where nothing is drawn

  const Scene *source;  // the host's, which must outlive this

  Mover *movers;  // [mover_count], in the order of objects: of the last device_scene_move
  uint32_t mover_count;
  bool trees_rebuilt;  // by the last device_scene_move: triangles of the trees lie in another order
  KeptScene *kept;     // NULL unless made by device_scene_make_movable

  uint32_t vertex_count, triangle_count, object_count, light_count, material_count;
  bool has_textures, has_second_uvs, has_normal_maps, has_masks, has_blends, has_colors, has_mirrors, has_shadowless;
  bool environment_lights;
  float least_roughness;  // as in FlatScene
  double extent_m;        // diagonal of the bounds
} DeviceScene;

// Flattens, builds the BVH and uploads; the host copies are freed, and `scene` keeps its environment. Host steps go to
// `timeline` when it is not NULL. Errors: those of flat_scene_make, bvh2_build and buffer_create.
Status device_scene_make(DeviceScene *out, Device *device, const Scene *scene, Timeline *timeline, Log *log);
void device_scene_free(DeviceScene *scene);

// The same, and keeps on the host what device_scene_move needs: the flattened geometry, the trees and the meshes' pose,
// some 250 bytes a triangle where vertices are shared.
Status device_scene_make_movable(DeviceScene *out, Device *device, const Scene *scene, Timeline *timeline, Log *log);

// Follows scene->source, whose objects, meshes and lights moved in place; counts of objects, vertices, triangles and
// lights must be as they were. Fills movers; writes what changed of geometry, trees and lights, and the bounds. Hits
// and pictures are those of a scene made anew, bit for bit. Where trees_rebuilt buffers of trees may be others
// afterwards, and triangles lie in another order: what names them has to be made again.
//
// Cost, 300 k triangles on two cores: 0.06 ms where nothing moved, 0.3 ms where a thousand triangles did, 15 ms where
// all did; 40 ms where the trees have to be built anew (bvh_refit.h).
//
// Errors: STATUS_FAILED (not movable, or counts changed), STATUS_NO_MEMORY, those of bvh2_build and buffer_create; the
// scene is then only fit for device_scene_free.
Status device_scene_move(DeviceScene *scene, Device *device, Timeline *timeline, Log *log);

// The object of a triangle, by the first triangles of all objects.
uint32_t object_of_triangle(const uint32_t *object_starts, uint32_t object_count, uint32_t triangle);

// Fills has_textures to has_colors and has_shadowless alone, from a scene whose images may not be decoded yet: what
// device_scene_options tells.
void device_scene_features(DeviceScene *out, const Scene *scene);

// What kernels do with a scene, as far as code for it is there in scenes alone that have such things.
typedef enum SceneUse {
  READS_SURFACES = 1,    // materials with their textures, where a ray hits
  TESTS_MASKS = 2,       // whether alpha MASK cuts a hit
  TESTS_BLENDS = 4,      // how much light BLEND lets through
  SKIPS_SHADOWLESS = 8,  // triangles that cast no shadow
} SceneUse;

// "-D HAS_TEXTURES ..." for kernels whose uses of the scene (SceneUse, added up) are these: no code is compiled for
// what the scene lacks, and scenes that differ in what the kernels do not look at share them.
void device_scene_options(const DeviceScene *scene, uint32_t uses, char *out, size_t size);

// Scenes of a few shapes, made in memory, for tests that render and for the catalogue of failures. Where memory runs
// out nothing is added and scene->incomplete is set: ask scene_check_complete once at the end. scene_free frees what
// they make.
#pragma once

#include "scene/scene.h"

// Nothing in the dark: no objects, no lights, a black environment.
Scene scene_empty(void);

// The same radiance from everywhere, or an image given as a colour for each of `width` x `height` pixels (copied).
void scene_set_constant(Scene *scene, double red, double green, double blue);
void scene_set_image(Scene *scene, uint32_t width, uint32_t height, const float (*colors)[3]);

// Single-sided and opaque, without textures.
Material material_plain(Vec3 base, double metallic, double roughness);
Material material_glowing(Vec3 emission);  // reflects nothing in phong, and next to nothing in pbr
int scene_add_material(Scene *scene, Material material);

// Four bytes a texel (copied), repeated and filtered; change scene->textures[] for others. Returns the texture, for a
// material's slots.
int scene_add_texture(Scene *scene, uint32_t width, uint32_t height, const uint8_t (*texels)[4]);

// Shapes with a material of the scene; each returns its object. The front of a quad (corner, corner + u,
// corner + u + v, corner + v) is where u x v points, that of a box or a sphere is outside. A texture lies upright on a
// quad, u to the right and v upwards, and so on each face of a box; triangles and spheres have no coordinates.
uint32_t scene_add_triangle(Scene *scene, int material, const Vec3 corners[3], const Vec3 normals[3]);
uint32_t scene_add_quad(Scene *scene, int material, Vec3 corner, Vec3 u, Vec3 v);
uint32_t scene_add_box(Scene *scene, int material, Vec3 low, Vec3 high);

// `rings` x 2 rings faces with the sphere's own normals, inside it by twice radius x (1 - cos(pi / 2 / rings)) at most.
uint32_t scene_add_sphere(Scene *scene, int material, Vec3 center, double radius, int rings);

// Makes one object of the last two: the first of them then has the materials and shapes of both.
void scene_join_last(Scene *scene);

// White lights; change what they return for others.
Light light_point(Vec3 position, double intensity_cd);
Light light_spot(Vec3 position, Vec3 towards, double intensity_cd, double inner_rad, double outer_rad);
Light light_directional(Vec3 direction, double intensity_lux);
void scene_add_light(Scene *scene, Light light);

// Cameras at `eye` that look at `target`, upright, or with -Z up where they look straight down or up.
Camera camera_perspective(Vec3 eye, Vec3 target, double yfov_rad);
Camera camera_orthographic(Vec3 eye, Vec3 target, double ymag_m);

// Is all there that was added? Errors: STATUS_NO_MEMORY.
Status scene_check_complete(const Scene *scene, Log *log);

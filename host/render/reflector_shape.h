// What the shape of a reflector allows.
#pragma once

#include "device_scene/device_scene.h"

// Does nothing that leaves a side of the object which can be seen meet the object again? So it is where no vertex lies
// above the plane of a triangle, by its front, and both sides are seen of flat objects alone. False too where finding
// out would take over CONVEX_TESTS_MOST tests of a vertex against a plane, an eighth of a nanosecond each.
#define CONVEX_TESTS_MOST 5e7
bool object_is_convex(const Scene *scene, uint32_t object);

// Is it a mirror by its factors? One whose roughness is a texture's may be one in places, and is not.
static inline bool material_is_mirror(const Material *material) { return material->roughness <= 0 && !material->unlit; }

// The plane of a triangle, world space: dot(normal, p) = offset_m, to whose side the unit normal points.
typedef struct MirrorPlane {
  Vec3 normal;
  double offset_m;
  Vec3 at;        // a point of the triangle
  double size_m;  // of the triangle
} MirrorPlane;

// False where the triangle has no area, or reflects as if it were not flat: by the normals of its corners or a map.
bool plane_of_triangle(MirrorPlane *out, const Scene *scene, uint32_t object, const Primitive *primitive,
                       uint32_t triangle);

// Are they the same plane and side, but for rounding?
bool planes_are_one(const MirrorPlane *a, const MirrorPlane *b);

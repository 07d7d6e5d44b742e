// Who reflects where the camera sees it.
#pragma once

#include "render/frame.h"
#include "render/reflector_shape.h"

enum { SIGHT_PX = 320 };

// Of a box no more are seen.
enum { SIDES_MOST = 3 };

typedef struct Side {
  MirrorPlane plane;
  uint32_t pixels;  // of the small picture that show it
} Side;

// A place of a surface that the camera sees: nothing lies on the way.
typedef struct RoughSight {
  Vec3 place_m, way_m;  // from the camera, or from where an orthographic one looks, to the place
} RoughSight;

// What is seen of an object's mirrors and of its rough surfaces, in pixels of the small picture.
typedef struct Reflector {
  uint32_t object;
  uint32_t pixels;
  Side sides[SIDES_MOST];  // the first that were seen
  uint32_t rough_pixels;   // that reflect at all, up to the plan's max_roughness
  float least_roughness;   // of these; with a texture the least of the scene's
  Vec3 rough_sum_m;        // of their places, world space
  RoughSight sight;        // about the middle of them
} Reflector;

// The side of which most is seen.
const Side *reflector_side(const Reflector *reflector);

// Are cubes' levels asked for what its rough surface reflects?
bool material_asks_levels(const Material *material, const Frame *frame);

// Counts one more pixel that shows a rough surface of the object.
void reflector_see_rough(Reflector *reflector, uint32_t object, float roughness, const RoughSight *sight);

// Counts one more pixel for the object of a triangle where that is seen, with `sight` NULL its mirrors alone. `starts`
// are the objects' first triangles.
void reflector_see(Reflector *reflectors, const Frame *frame, const uint32_t *starts, uint32_t triangle,
                   const RoughSight *sight);

// Fills reflectors[object] for all objects, [object_count], which are zero before, by tracing the picture at no more
// than SIGHT_PX pixels a side; *factor is how many pixels of the picture each of its pixels is wide. Unless it is NULL,
// within[object] is the same for mirrors that are seen in mirrors (render/mirrors_within.h).
Status mirrors_see(Reflector *reflectors, Reflector *within, uint32_t *factor, Frame *frame, Log *log);

// Triangles in world space for the oracles: written from the definition of the right image alone, in double precision,
// sharing no code with the renderer but the scene model and host/base/math3d.h.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "scene/scene.h"

#define ORACLE_MISS 0xffffffffu

// Flags of a triangle; the values are those of TRIANGLE_* in cl/shared/bvh.h.
#define ORACLE_SINGLE_SIDED 1u  // rays that cull pass through it from behind
#define ORACLE_SEE_THROUGH 2u   // alpha MASK or BLEND: `coverage` is asked

// Triangle `index` of a primitive of an object; corners are vertices of the primitive, the last two exchanged where the
// object is mirrored. All zero but the corners where the triangles came without a Scene.
typedef struct OracleTriangle {
  uint32_t object, primitive, index;
  uint32_t corners[3];
  uint32_t flags;
} OracleTriangle;

enum { ORACLE_BLOCK = 32 };

typedef struct OracleBlock {
  float vertices[3][3][ORACLE_BLOCK];  // [corner][axis]; NaN where unused
  float longest_m[ORACLE_BLOCK];       // longest edge, rounded up
} OracleBlock;

typedef struct OracleScene OracleScene;

// Share of the light that the point (u, v) of a triangle stops: 0 is not there at all. Lowers *margin to how far u or v
// is from another answer.
typedef double (*OracleCoverage)(const OracleScene *scene, uint32_t triangle, double u, double v, double *margin);

struct OracleScene {
  const Scene *model;  // NULL for plain triangles
  OracleTriangle *triangles;
  OracleBlock *blocks;
  uint32_t triangle_count, block_count;
  double scale_m;           // diagonal of the bounds
  OracleCoverage coverage;  // of triangles with ORACLE_SEE_THROUGH; NULL: they stop all light
};

// Bakes the objects of `model`, which must outlive the result: ids count objects, primitives and triangles in order;
// positions are rounded to float, as a device gets them. Ends the program where memory runs out. Set `coverage` (see
// oracle_surface.h) for a model with alpha.
OracleScene oracle_scene_from_model(const Scene *model);
void oracle_scene_free(OracleScene *scene);

// World position of a corner (0..2).
Vec3 oracle_vertex(const OracleScene *scene, uint32_t triangle, int corner);

const Primitive *oracle_primitive(const OracleScene *scene, uint32_t triangle);
const Material *oracle_material(const OracleScene *scene, uint32_t triangle);

// calloc that ends the program where memory runs out.
void *oracle_array(size_t count, size_t element_bytes);

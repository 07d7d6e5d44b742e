// Which triangles belong to closed surfaces: what hybrid shadows may leave out of their lists
// (cl/raster/shadow_setup.cl).
#pragma once

#include "base/log.h"
#include "scene/scene.h"
#include "shared/camera.h"
#include "shared/scene.h"

// A closed, consistently wound, connected piece of an object that casts shadows, none of it masked or blended.
typedef struct SolidPiece {
  uint32_t object;
  uint32_t number;  // of the piece in its mesh
  Vec3 low, high;   // world space
} SolidPiece;

typedef struct Solids {
  const Scene *scene;
  uint32_t **mesh_pieces;  // [mesh_count][triangles of the mesh]: the piece, or SOLID_NONE
  SolidPiece *pieces;
  uint32_t piece_count;
  uint32_t *bits;  // bit i % 32 of word i / 32: triangle i of the flattened scene is of a piece
  uint32_t word_count;
} Solids;

#define SOLID_NONE 0xffffffffu

// Finds the pieces. Vertices at the same place are one; an edge is closed where as many triangles pass it one way as
// the other. Once for each stored mesh, meshes side by side. The scene must outlive it. Errors: STATUS_NO_MEMORY.
Status solids_make(Solids *out, const Scene *scene, Log *log);
void solids_free(Solids *solids);

// Whether what a camera sees, directly or by way of mirrors, lies no deeper in any piece than the light does, so that a
// ray between them crosses as many averted triangles as facing ones, or more. Decided by winding numbers, with care:
// false where one is not near a whole number, and where a piece reaches into the camera's near plane.
//   From  van Oosterom, Strackee, "The Solid Angle of a Plane Triangle", 1983 (the winding number).
bool solids_suit(const Solids *solids, const LightInfo *light, const CameraInfo *camera);

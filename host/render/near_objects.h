// The lists of what is near reflectors' cube maps, and the snapshots of them.
#pragma once

#include "passes/near_reflect.h"
#include "passes/snapshot_capture.h"
#include "plan/near_list.h"

typedef struct Frame Frame;

// By cube.
typedef struct NearObjects {
  NearList *lists;
  uint32_t *reflectors;  // objects
  NearInfo *nears;
  SnapshotInfo *snapshots;  // [snapshot_count], of all cubes
  uint32_t cube_count, snapshot_count;
  uint32_t left_out;  // near objects that are over the limit: they stay in the cube map, with its parallax
  size_t snapshot_texels;
  uint64_t bytes;  // of trees and snapshots
} NearObjects;

// Lists what is near each cube's centre, for a plan that uses lists, and chooses how each is found. `bytes_left` is
// what trees and snapshots may take. A reflector whose own triangles do not fit loses its cube: its entry in
// cube_of_object becomes CUBE_NONE. Objects over the limit stay in the cube map; both are said in a warning.
// Errors: STATUS_NO_MEMORY.
Status near_objects_list(NearObjects *out, const Frame *frame, const CubeInfo *cubes, uint32_t cube_count,
                         uint32_t *cube_of_object, uint64_t bytes_left, Log *log);
void near_objects_free(NearObjects *near);

// Sets left_out[object] to 1 for all that are listed for a cube.
void near_objects_mark(const NearObjects *near, uint32_t cube, uint32_t *left_out);

// The radius about a reflector's cube within which objects are near, as the options have it.
double near_objects_radius_m(const CubeOptions *options, const ObjectFacts *reflector);

// Texels a side of the snapshot of an object that reaches `across` at a distance of 1, margins included, beside a cube
// of cube_px.
uint32_t snapshot_size_px(double across, uint32_t cube_px);
enum { SNAPSHOT_MARGIN_PX = 2 };

// Builds the lists' trees and makes frame->near_reflect. Errors: those of part_bvh_make and near_reflect_make.
Status near_objects_make(Frame *frame, const CubeInfo *cubes, Log *log);

// Takes the snapshots, and measures how the cubes, which are drawn, change. The frame is in the midst of a capture.
Status near_objects_draw(Frame *frame, const CubeInfo *cubes, uint32_t samples, Log *log);

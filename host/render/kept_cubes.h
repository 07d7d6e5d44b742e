// Cube maps that a frame of a sequence takes from the frame before it, face by face.
#pragma once

#include "passes/camera_rays.h"
#include "passes/cube_lit.h"
#include "passes/cube_reflect.h"
#include "passes/light_reach.h"

typedef struct Frame Frame;

// First come the cubes of what the camera sees, mirrors' first, then deep ones, of mirrors that it sees in others.
typedef struct CubeOrder {
  uint32_t count, mirrors, first_deep;
} CubeOrder;

// What a frame's cube maps were drawn of.
typedef struct CubeRecord {
  CubeInfo *cubes;    // [order.count], the host's copy
  float *nears_m;     // [the same], nothing nearer to the centre is in them
  bool *redrawn;      // [the same], faces of them are not those of the frame before
  LightInfo *lights;  // [light_count], as they were
  CubeOrder order;
  uint32_t light_count;
  CameraInfo camera;  // of the picture
} CubeRecord;

// Errors: STATUS_NO_MEMORY.
Status cube_record_make(CubeRecord *out, const Frame *frame, const CubeInfo *cubes, const CubeOrder *order, Log *log);
void cube_record_free(CubeRecord *record);

// What is nearer to a cube's centre is within the reflector, or nearer than a picture of the whole scene tells apart.
float cube_near_m(const DeviceScene *scene, const CubeInfo *cube);

// Are all cubes those of the frame before, and nothing has moved? Then all that was made about them may be taken as it
// is. frame->cubes_drawn is there.
bool cubes_stayed(const Frame *frame);

enum { CUBE_ALL_FACES = (1 << CUBE_FACES) - 1 };

// What is not as it was in the frame before, besides what moved.
typedef struct CubeChanges {
  bool lights_differ;  // in number
  LightReach *lights;  // [light_count], where those that changed shine and shone
  uint32_t light_count;
  CubeLit lit;           // the same by texels; not made where BLEND surfaces may be seen through
  ObjectFacts *objects;  // of the scene; NULL where nobody asks
} CubeChanges;

// frame->cubes_drawn is there. Errors: STATUS_NO_MEMORY, those of program_build.
Status cube_changes_make(CubeChanges *out, const Frame *frame, Log *log);
void cube_changes_free(CubeChanges *changes);

// Takes one cube from the frame before, where it had the same, and says which faces are to be drawn anew: bit f of
// *faces; their texels are zero. Deep cubes are taken before others. A face stays when nothing that moved is seen on
// it, nor the shadow of that; when no light that changed, or whose shadows are found by other maps, shines on what is
// seen on it, before or after; and when no mirror is seen on it whose deep cube, which shows there, has changed. Where
// things are seen by way of others (deep reflections by rays), nothing stays once something moves or a light changes;
// where the environment is sampled or maps blur shadows, once something moves. Errors: STATUS_DEVICE.
Status cube_take(uint32_t *faces, Frame *frame, uint32_t cube, const CubeChanges *changes, Log *log);

// Triangles in the order of the BVH's leaves -> blocks of 16, structure of arrays, and the bounds of each chunk of
// them. Once a scene.
//
//   in    triangles  [triangle_count]
//   out   blocks     [chunk_count][RASTER_CHUNK_BLOCKS]; unused slots are marked
//         bounds     [chunk_count]
//
//   Cost  92 bytes moved a triangle; one work-group a chunk.
//   Leaf order keeps neighbours together: a chunk is a compact piece of the scene, which a view keeps or drops as a
//   whole.

#include "shared/bvh.h"
#include "shared/raster.h"

kernel void triangle_pack(global const BvhTriangle *triangles, uint triangle_count, global RasterBlock *blocks,
                          global RasterBounds *bounds)
{
  local RasterBounds parts[GROUP_SIZE];
  uint chunk = get_group_id(0), member = get_local_id(0);
  RasterBounds own = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  for (uint i = member; i < RASTER_CHUNK; i += GROUP_SIZE) {
    uint from = chunk * RASTER_CHUNK + i, slot = i % RASTER_STEP;
    global RasterBlock *block = &blocks[chunk * RASTER_CHUNK_BLOCKS + i / RASTER_STEP];
    bool used = from < triangle_count;
    global const BvhTriangle *triangle = &triangles[used ? from : 0];
    block->id[slot] = used ? triangle->id : RASTER_UNUSED;
    block->flags[slot] = triangle->flags;
    for (uint corner = 0; corner < 3; corner++) {
      for (uint axis = 0; axis < 3; axis++) {
        float value = triangle->vertex[corner][axis];
        block->vertex[corner][axis][slot] = value;
        own.low[axis] = value < own.low[axis] ? value : own.low[axis];
        own.high[axis] = value > own.high[axis] ? value : own.high[axis];
      }
    }
  }
  parts[member] = own;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (member >= 3) return;
  for (uint axis = member; axis < 3; axis += GROUP_SIZE) {
    float low = INFINITY, high = -INFINITY;
    for (uint i = 0; i < GROUP_SIZE; i++) {
      low = parts[i].low[axis] < low ? parts[i].low[axis] : low;
      high = parts[i].high[axis] > high ? parts[i].high[axis] : high;
    }
    bounds[chunk].low[axis] = low;
    bounds[chunk].high[axis] = high;
  }
}

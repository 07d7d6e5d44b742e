// Triangles in the order of the BVH's leaves -> blocks of 16, structure of arrays, and the bounds of each chunk of
// them. Once a scene.
//
//   in    triangles  [triangle_count]
//   out   blocks     [chunk_count][RASTER_CHUNK_BLOCKS]; unused slots are marked
//         bounds     [chunk_count]
//
//   Cost  92 bytes moved a triangle; one work-item a chunk.
//   Leaf order keeps neighbours together: a chunk is a compact piece of the scene, which a view keeps or drops as a
//   whole.

#include "shared/bvh.h"
#include "shared/raster.h"

kernel void triangle_pack(global const BvhTriangle *triangles, uint triangle_count, global RasterBlock *blocks,
                          global RasterBounds *bounds)
{
  uint chunk = get_global_id(0), chunk_count = (triangle_count + RASTER_CHUNK - 1) / RASTER_CHUNK;
  if (chunk >= chunk_count) return;
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (uint i = 0; i < RASTER_CHUNK; i++) {
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
        low[axis] = value < low[axis] ? value : low[axis];
        high[axis] = value > high[axis] ? value : high[axis];
      }
    }
  }
  for (uint axis = 0; axis < 3; axis++) {
    bounds[chunk].low[axis] = low[axis];
    bounds[chunk].high[axis] = high[axis];
  }
}

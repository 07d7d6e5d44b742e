// Sizes and records of the raster stages. Filled and read by cl/raster, allocated by host/passes/raster*.c.
#ifndef SHARED_RASTER_H
#define SHARED_RASTER_H

#include "shared/types.h"

#define RASTER_STEP 16     // triangles of a RasterBlock: one vector
#define RASTER_CHUNK 1024  // triangles that one work-item sets up and bins
#define RASTER_CHUNK_BLOCKS (RASTER_CHUNK / RASTER_STEP)
#define RASTER_BIN_PX 64  // side of the squares of pixels that triangles are sorted into
#define RASTER_LARGE_BINS \
  16  // a triangle in more bins goes to the chunk's list of large ones, which every bin looks at

// Triangles in the order of the BVH's leaves, structure of arrays. Unused slots have the id RASTER_UNUSED.
typedef struct RasterBlock {
  float vertex[3][3][RASTER_STEP];  // world space, [corner][axis][slot]
  uint id[RASTER_STEP];
  uint flags[RASTER_STEP];  // TRIANGLE_*
} RasterBlock;
SHARED_SIZE(RasterBlock, 704);

#define RASTER_UNUSED 0xffffffffu

// Bounds of a chunk, world space.
typedef struct RasterBounds {
  float low[3], high[3];
} RasterBounds;
SHARED_SIZE(RasterBounds, 24);

// A chunk to set up for a view of the table.
typedef struct RasterItem {
  uint chunk, view;
} RasterItem;
SHARED_SIZE(RasterItem, 8);

// Setup is launched for a multiple of that many items: neighbouring work-items are this share of all apart.
#define RASTER_SPREAD 16

#define RASTER_UNSEEN 0xffffffffu  // the view of an item behind the last one

// Where the survivors of an item are in its view, structure of arrays [SPAN_FIELDS][items], and SPAN_PADDING words
// behind it: how many, which bins they touch, [first, end), and how near.
#define SPAN_COUNT 0
#define SPAN_FIRST_X 1
#define SPAN_FIRST_Y 2
#define SPAN_END_X 3
#define SPAN_END_Y 4
#define SPAN_NEAR 5   // bits of a float not below 0: nothing is drawn nearer
#define SPAN_ORDER 6  // the same of how far it is, front and back together: what is drawn first
#define SPAN_FIELDS 7
#define SPAN_PADDING 16

#define LIST_PADDING 16  // numbers behind the last chunk's lists

// Words of a triangle's record for camera visibility (cl/raster/visibility_setup.cl).
#define VISIBLE_EDGE \
  0  // 3 times (x, y, constant): >= 0 where a 4 x 4 block that starts at pixel sample (x, y) may be met
#define VISIBLE_BOUNDS 9   // floats: low x, low y, high x, high y in pixels, what rounding may add included
#define VISIBLE_NEAR 13    // float: no hit is nearer
#define VISIBLE_NUMBER 14  // of the triangle in the blocks
#define VISIBLE_FLAGS 15   // TRIANGLE_*
#define VISIBLE_WORDS 16

// Words of a triangle's record for depth maps (cl/raster/depth_setup.cl). What a map shows of it is settled by
// integers: vertices in 1/256 of a texel from the map's top left corner, turned so that the area is positive.
#define DEPTH_VERTEX 0   // 6 ints: x, y of each corner
#define DEPTH_PLANE 6    // floats: depth at corner 0, its growth by 1/256 of a texel along x and y
#define DEPTH_LIMITS 9   // floats: least and greatest depth of the corners
#define DEPTH_UNUSED 12  // two words
#define DEPTH_NUMBER 14  // of the triangle in the blocks
#define DEPTH_FLAGS 15   // TRIANGLE_*, DEPTH_CLIPPED
#define DEPTH_WORDS 16

// The triangle crosses the eye plane or leaves the range of the integers: words 0 to 11 hold x, y, depth and w of each
// corner before division, for whoever draws it to clip.
#define DEPTH_CLIPPED 0x80000000u

// A triangle that a work-item of its own would take too long for, in the list of the direct way (cl/lib/boxes.cl).
typedef struct RasterBox {
  uint number;  // of the triangle in the blocks
  uint view;    // of the view table
  uint x, y;    // pixels: first | last << 16
} RasterBox;
SHARED_SIZE(RasterBox, 16);

#define RASTER_SMALL_PX 36  // pixels of a box up to which one work-item draws the triangle
#define RASTER_TILE_PX 32   // RASTER_TEAM work-items draw a larger one by tiles of this side
#define RASTER_TEAM 32
#define RASTER_LISTED_SAMPLES 1024  // of small triangles, that a work-group lists before it draws them
#define RASTER_TILE_VECTORS 6       // of four words: a triangle set up for a tile, as cl/raster/*_direct.cl say

#define RASTER_VIEWS_MOST 32  // that one launch of the direct way draws: bits of a word

// Counts of those lists, of 64 bits each; two sets of them.
#define RASTER_BOX_COUNT 0    // boxes to split and their tiles: cl/lib/boxes.cl
#define RASTER_TILE_COUNT 1   // tiles
#define RASTER_TAKEN_COUNT 2  // tiles that teams have taken
#define RASTER_BOX_COUNTS 3

// Sums of what raster took, each of two words, low word first.
#define RASTER_COST_TESTS 0    // triangles tried on blocks of 4 x 4 samples
#define RASTER_COST_COVERED 2  // samples they then covered
#define RASTER_COSTS 4

#define RASTER_SNAP 256        // parts of a texel
#define RASTER_GUARD_PX 16384  // coordinates of vertices stay within it

#endif

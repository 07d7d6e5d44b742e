// Shadow maps of one light as cl/shade and cl/raster read them. Written by host/passes/shadow_fit.c.
#ifndef SHARED_SHADOW_H
#define SHARED_SHADOW_H

#include "shared/types.h"
#include "shared/view.h"

// One map of a light: the 2007 system's chain bias x light projection x light view x inverse camera view as one matrix,
// map_from_world, here as the rows of `raster`; the hits are in world space, so that the camera's part is done. What a
// texel sees is the other way round: at pixel (x, y) of the map, light travels along sight_0 + x sight_x + y sight_y
// (relative to raster.origin, at w = 1), or in parallel projection through that point at depth 0, along `axis` to depth
// 1.
typedef struct ShadowView {
  RasterView raster;
  Float3 sight_0, sight_x, sight_y;
  Float3 axis;
} ShadowView;
SHARED_SIZE(ShadowView, 188);

#define SHADOW_VIEWS_MOST 6

// Which of a light's maps a point is looked up in.
#define SHADOW_VIEWS_ONE 0u       // a spot light's
#define SHADOW_VIEWS_CUBE 1u      // by the largest component from the light: +x, -x, +y, -y, +z, -z
#define SHADOW_VIEWS_CASCADES 2u  // the first that holds it, with its kernel: the finest comes first

#define SHADOW_BY_TEXEL 0u
#define SHADOW_BY_PCF 1u
#define SHADOW_BY_PCSS 2u
#define SHADOW_BY_TRIANGLES 3u  // hybrid

typedef struct ShadowInfo {
  uint method;  // SHADOW_BY_*
  uint views;   // SHADOW_VIEWS_*
  uint view_count;
  uint size_px;
  uint gutter_px;     // texels at a map's rim that no lookup is centred on
  uint kernel_px;     // PCF: texels a side, odd
  float radius;       // PCSS: of the light in metres; directional: tangent of its angular radius x depth 1 in metres
  float depth_slack;  // what rounding may do to a depth
  float slope_px;     // texels by whose growth of the receiver's plane a caster must stand before it
  uint first_view;    // among the views and the texels of all lights' maps; SHADOW_BY_TRIANGLES: the tiles
  uint first_texel;
} ShadowInfo;
SHARED_SIZE(ShadowInfo, 44);

// PCSS: texels of its two discs, and their greatest radius.
#define SHADOW_DISC_TAPS 32
#define SHADOW_DISC_PX 24

// What hybrid shadows know of a light's maps, by tiles of 4 x 4 blocks of 4 x 4 texels. Closeness is 1 / w, or in
// parallel projection -depth: what is closer to the light has more of it. All holds beyond SHADOW_ROUNDING.
//
// A tile is known where the picture's receivers are: texels of others, and points less close than `least`, are not
// drawn. A ray from a point closer than `near` is lit, from one less close than `covered` dark, wherever in the tile it
// is. Where `near` is -INFINITY nothing is in the tile, and its blocks are not there.
#define SHADOW_TILE_PX 16
#define SHADOW_TILE_BLOCKS 16  // row by row, from `first_block` on, among those of all lights
#define TILE_COLUMNS(size_px) (((size_px) + SHADOW_TILE_PX - 1) / SHADOW_TILE_PX)

typedef struct ShadowTile {
  uint first_block;  // SHADOW_TILE_UNKNOWN
  float least;
  float near;
  float covered;
} ShadowTile;
SHARED_SIZE(ShadowTile, 16);

#define SHADOW_TILE_UNKNOWN 0xffffffffu

// Texel (x, y) of a map is entry y % 4 * 4 + x % 4 of its block. A ray from a point that is less close than `covered`
// is dark. Triangle `number` comes no closer than `near`, in the texel; a texel names up to SHADOW_NUMBERS of them, the
// closest first, and no other comes closer than `rest`. The lists of a block's texels are rows: the first in the block,
// row k > 0 of block i of all maps' `block_count` at rows[(k - 1) * block_count + i], so that what no list is long
// enough for is not touched. Where a list is shorter than its block's, `near` is -INFINITY. What comes less close than
// `covered` means nothing.
#define SHADOW_NUMBERS 8

// The triangle is marked: of a closed surface, of which the sides that face the light are left out.
#define SHADOW_CLOSED 0x80000000u

typedef struct ShadowRow {
  float near[16];
  uint number[16];  // in the order of the BVH's leaves, SHADOW_CLOSED added
} ShadowRow;
SHARED_SIZE(ShadowRow, 128);

typedef struct ShadowBlock {
  float covered[16];  // a triangle that hides all of the texel is this close everywhere in it
  float rest[16];
  ShadowRow first;
  uint row_count;
  uint unused[15];
} ShadowBlock;
SHARED_SIZE(ShadowBlock, 320);

// Verdicts that a sequence keeps of camera rays' hits, [VERDICT_FIELDS][slots of the picture, sample by sample]: where
// the shadow ray began, and of each of the first lights VERDICT_BITS: lit, dark or neither, and the view that it was
// looked up in. They hold in the next frame for rays that begin there, to lights that are the same, by views that see
// nothing that moved.
#define VERDICT_ORIGIN 0  // 3 floats
#define VERDICT_KNOWN 3
#define VERDICT_FIELDS 4
#define VERDICT_LIGHTS 4  // LIGHTS_PER_LAUNCH of shared/shade.h
#define VERDICT_BITS 5    // VERDICT_LIT or VERDICT_DARK | view << 2
#define VERDICT_LIT 1u
#define VERDICT_DARK 2u

#define SHADOW_ROUNDING 2e-5f           // of 1 / w, relative
#define SHADOW_ROUNDING_PARALLEL 4e-6f  // of depths in [0, 1]

// What marks of triangles mean when maps are drawn: a light's, where what casts no shadow is left out, or a cube's.
#define SURE_NONE_MARKED 0u
#define SURE_MARKED_SOLID 1u     // of closed surfaces: the sides that face the light are left out
#define SURE_MARKED_LEFT_OUT 2u  // of a cube: all others are drawn

// Words of a triangle's record for them (cl/raster/shadow_setup.cl).
#define SURE_EDGE 0  // 3 times (x, y, constant), floats: >= 0 where texel (x, y) may be touched
// Floats: closeness over texel (x, y) is at most [0] + [1] x + [2] y; [3] the most and [4] the least of the vertices';
// [5] what rounding may do to an edge.
#define SURE_NEAR 9
#define SURE_TEXELS 15  // first x | last x << 16, the same for y
#define SURE_NUMBER 17  // of the triangle in the blocks, SHADOW_CLOSED added
#define SURE_HIDES 18   // 1: what lies behind it is dark
#define SURE_ACROSS 19  // float: over a texel closeness is less than its most by this at most
#define SURE_VIEW 20    // the direct way: of the view table
#define SURE_WORDS 32

// The direct way (cl/raster/shadow_direct.cl): records have fewer words; counts of its lists.
#define SURE_DIRECT_WORDS 24
#define SURE_BIN_PX 16  // side of its bins
#define SURE_RECORD_COUNT 0
#define SURE_LIST_COUNT 1  // of all lists
#define SURE_COUNTS 2      // and behind them that of each list

#define SURE_PADDING 0.05f  // texels by which all are taken to be larger

#endif

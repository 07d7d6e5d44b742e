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
SHARED_SIZE(ShadowView, 180);

#define SHADOW_VIEWS_MOST 6

// Which of a light's maps a point is looked up in.
#define SHADOW_VIEWS_ONE 0u       // a spot light's
#define SHADOW_VIEWS_CUBE 1u      // by the largest component from the light: +x, -x, +y, -y, +z, -z
#define SHADOW_VIEWS_CASCADES 2u  // the first that holds it, with its kernel: the finest comes first

#define SHADOW_BY_TEXEL 0u
#define SHADOW_BY_PCF 1u
#define SHADOW_BY_PCSS 2u

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
} ShadowInfo;
SHARED_SIZE(ShadowInfo, 36);

// PCSS: texels of its two discs, and their greatest radius.
#define SHADOW_DISC_TAPS 32
#define SHADOW_DISC_PX 24

// Lists of hybrid shadows: for each texel what may stand before a point that is seen through it.
#define SHADOW_LIST_LENGTH 6

typedef struct ShadowHead {
  uint nearest;  // bits of a float: no triangle of the texel is nearer; w, or in parallel projection depth, from 0 on
  uint count;    // of triangles; those beyond SHADOW_LIST_LENGTH are not in the list
} ShadowHead;
SHARED_SIZE(ShadowHead, 8);

#endif

// What of a light arrives at each pixel, by a method and by rays; and how far a map of that light may be off there.
#pragma once

#include "passes/shadow_fit.h"
#include "stability/lab.h"

// What lies between a pixel and the next of its row or column, as rays see it: an edge of a shadow; the end of a
// surface, behind which there may be one.
enum LitEdge { EDGE_ROW = 1, EDGE_COLUMN = 2, END_ROW = 4, END_COLUMN = 8 };

typedef struct LitView {
  DeviceScene scene;
  Shot truth;         // by rays
  float *lit, *rays;  // [height][width]: share of the light that arrives, by the method and by rays
  bool *seen;         // the light would reach it if nothing stood in its way
  uint8_t *edges;     // of LitEdge
  ShadowFit fit;      // of the method's maps
  bool fitted;        // false where the method has none
} LitView;

// Renders a scene with one light. `options` may be NULL: PCF of 3 texels, maps by magnification.
Status lit_view_make(LitView *out, Lab *lab, const Scene *scene, const Camera *camera, uint32_t width, uint32_t height,
                     ShadowMethod method, const ShadowOptions *options);
void lit_view_free(LitView *view);

size_t lit_view_seen(const LitView *view);

// Does the method differ visibly from rays at a pixel that is seen?
bool lit_view_is_wrong(const LitView *view, size_t pixel);
size_t lit_view_wrong(const LitView *view);

// Copies what the method and the rays show to the lab.
Status lit_view_keep(const LitView *view, Lab *lab);

// One texel's steps along x and y of the map that the pixel is looked up in, in pixels, on the plane that it shows.
typedef struct Footprint {
  double x[2], y[2];
} Footprint;

// False where the pixel is in no map, or its plane is seen or lit edge on.
bool lit_view_footprint(Footprint *out, const LitView *view, size_t pixel);

// Longer side of a footprint.
double footprint_length(const Footprint *footprint);

// Pixels between an edge of a shadow and a line `texels` of the map from it, summed over all edges that rays see. An
// edge that runs in direction n / |n| moves by |x . n| + |y . n| for a texel either way, and is crossed |n.x| times a
// pixel of its length by rows of the picture and |n.y| times by columns.
double lit_view_edge_pixels(const LitView *view, double texels);

// The same for the ends of surfaces.
double lit_view_end_pixels(const LitView *view, double texels);

// Neighbouring pixels of a surface with an edge between them, counted by rows and by columns.
size_t lit_view_edges(const LitView *view);

// Wrong pixels farther than `texels` of the map and a pixel from every edge that rays see, and from every end of a
// surface.
size_t lit_view_wrong_off_edges(const LitView *view, double texels);

// How far a caster of a directional light must stand before a plane with that normal to count, in metres along the
// light, at a point (world space).
double lit_view_bias_m(const LitView *view, Vec3 point, Vec3 normal);

// Side of a texel at a point, in metres across the light; 0 where no map holds it.
double lit_view_texel_m(const LitView *view, Vec3 point);

// How far a cube map is off, in closed form. No OpenCL here.
//
// A reflected ray leaves the reflector at P, o metres from the cube's centre C, in direction d, and meets something at
// H. The cube, asked for what lies in direction d, shows what C sees there; what the ray meets C sees in the direction
// of H. The angle eps between both is that of the triangle C P H at H, and by the law of sines
//
//   sin(eps) / o = sin(phi) / D,   phi the angle between CP and d (that at P is pi - phi), D the distance CH,
//
// so that sin(eps) = (o / D) sin(phi) <= o / D. It says nothing of what hides what: C may see H, P not, or the other
// way round, and then the whole of an object is there too much or too little; and where D < o any direction is
// possible.
//
// On the picture, what is seen in the reflector moves by eps over the change of the reflected ray from a pixel to the
// next. That is a pixel's own angle for a flat mirror, and 1 + 2 L / (R cos(theta)) times that, in the plane of
// incidence, for one of radius R (convex) at distance L, seen theta off its normal: the normal turns by L / (R
// cos(theta)) times the pixel's angle, the reflected ray by twice as much. A small convex reflector forgives, a flat
// mirror does not.
//
// From  Igehy, "Tracing Ray Differentials", 1999 (the change of a reflected ray).
#pragma once

#include <stdint.h>

// One reflected ray.
typedef struct CubeSight {
  double offset_m;    // o: of the point that reflects, from the cube's centre
  double distance_m;  // D: of what is reflected, from the cube's centre; INFINITY: nothing but the environment
  double angle_rad;   // phi: between the way from the centre to the point and the reflected ray
} CubeSight;

// The part of the picture that shows a reflector.
typedef struct ReflectorView {
  double pixel_rad;   // angle of a pixel
  double distance_m;  // L: of the reflector from the camera
  double radius_m;    // R: of its curvature, INFINITY where it is flat
  double slant_rad;   // theta: between its normal and the way to the camera
  double edge_px;     // length of all edges in what it shows
  double area_px;     // that it covers
} ReflectorView;

// eps; where D < o the greater of the two angles that a triangle may have, and pi where there is none.
double cube_parallax_rad(const CubeSight *sight);

// The same where phi is not known.
double cube_parallax_most_rad(double offset_m, double distance_m);

// The radius about the cube's centre outside of which that is no more than `most_rad` (up to pi / 2).
double cube_near_radius_m(double offset_m, double most_rad);

// The parallax that is put up with in `auto`: what is nearer is listed by the methods that can. The cube's distances
// correct the parallax of what it sees; this bounds what it does not see: the sides that only the reflector's own
// points do.
#define CUBE_NEAR_PARALLAX_RAD 0.35

// Greatest angle between two neighbouring texels, at the middle of a face: an edge may lie anywhere between them.
double cube_texel_rad(uint32_t size_px);

// Change of the reflected ray from a pixel to the next.
double reflected_change_rad(const ReflectorView *view);

// Pixels of the reflector that an error of `error_rad` makes wrong: what an edge sweeps as it moves, at most all of it.
double cube_wrong_px(const ReflectorView *view, double error_rad);

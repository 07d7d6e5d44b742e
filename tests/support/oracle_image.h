// Whitted's image of a scene in double precision: what every method of rendering is measured against.
// Source: Whitted, "An Improved Illumination Model for Shaded Display", 1980.
#pragma once

#include "support/oracle_shade.h"
#include "support/oracle_trace.h"

typedef struct OracleOptions {
  uint32_t width, height, samples;
  OracleModel model;
  double ambient;      // phong
  uint32_t max_depth;  // reflections in a row; 0 leaves mirrors without any
  bool cast_shadows;
} OracleOptions;

// pbr, ambient 0.05, depth 8, shadows.
OracleOptions oracle_options(uint32_t width, uint32_t height, uint32_t samples);

typedef struct OracleImage {
  uint32_t width, height;
  double (*radiance)[3];  // linear, [height][width] from the top left, mean of the samples
  double *margins;        // least of all rays of the pixel, as OracleHit.margin; 0 where the image is not defined
} OracleImage;

// Above this a pixel is `stable`: rays in single precision find the same triangles, lights and reflections.
#define ORACLE_STABLE 2e-5
bool oracle_image_stable(const OracleImage *image, uint32_t x, uint32_t y);

// Single-sided back faces are open to camera and reflected rays and block shadow rays; BLEND composes along the ray.
// Surfaces that are no mirrors reflect nothing but lights and environment, and nothing stands in the environment's way
// (oracle_environment_light). Not defined (margin 0): pixels whose shading normal faces away from the ray, or reflects
// it below the geometric plane. Sets scene->coverage to that of oracle_surface.h. Runs on all cores.
OracleImage oracle_image_render(OracleScene *scene, const Camera *camera, const OracleOptions *options);
void oracle_image_free(OracleImage *image);

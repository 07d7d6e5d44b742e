// One point of a plane under an environment, with something in the way or not: pictures of it, and what they must show.
#pragma once

#include "support/picture_fixture.h"

// Mean of a rectangle of a picture, and the standard error of it as its pixels tell.
typedef struct Mean {
  double value, error;
} Mean;

Mean mean_of(const Picture *picture, uint32_t x, uint32_t y, uint32_t width, uint32_t height, int channel);

// Fails beyond 4.5 standard errors and what the oracle's own grid may be off by.
void mean_check(Mean got, double wanted, double oracle_error, const char *what);

// What stands over the point: nothing, a black ball, or a black sheet that covers the whole sky.
typedef enum Cover { COVER_NONE, COVER_BALL, COVER_SHEET } Cover;

// An image that varies by direction, with a sun 45 degrees high that the ball does not hide.
void plane_set_image(Scene *scene);

// A small quad in the plane y = 0 about the origin, of the scene's first material.
Scene plane_scene(Material material);
Material plane_black_unlit(void);
void plane_add_cover(Scene *scene, Cover cover, Material material);

// BRDF x radiance x visibility x n.l over the hemisphere above the plane, by midpoints in y and azimuth; of both lobes,
// or of the specular one alone.
Vec3 plane_integral(const Environment *environment, const OracleSurface *surface, Cover cover);
Vec3 plane_lobes_integral(const Environment *environment, const OracleSurface *surface, Cover cover, bool diffuse);

// The point as all pixels of a picture of PATCH x PATCH see it, and whether its mean is what is wanted.
enum { PATCH = 16 };
Picture plane_picture(const Scene *scene, const PictureRequest *request);
void plane_check(const Scene *scene, const PictureRequest *request, Vec3 wanted, const char *what);

double plane_component(Vec3 v, int channel);

// Scenes with mirrors and pictures of them, for tests of what answers reflected rays.
#pragma once

#include "render/frame.h"
#include "support/picture_fixture.h"

// Square, one sample a pixel; `cube_px` 0: auto.
PictureRequest mirrors_request(uint32_t side, ReflectionMethod method, uint32_t cube_px);

// A mirror's material, of reflectance 0.9.
int mirrors_material(Scene *scene, bool double_sided);

// A sky as smooth as a cosine, so that its second derivative is 1 a radian squared at most.
void mirrors_sky(Scene *scene);

// The greatest difference of a pixel's channels.
double mirrors_difference(const Picture *a, const Picture *b, size_t pixel);

// Pixels that differ by more than `most`, of those within `reach` of which rays show one thing; *even: how many these
// are.
size_t mirrors_even_wrong(const Picture *rays, const Picture *maps, int reach, double most, size_t *even);

// A room of six glowing walls of tiles, from (-1.9, -1.2, -2.3) to (2.4, 1.6, 1.7): none is a face of a cube about the
// origin.
Scene mirrors_room(void);

// Which reflectors have maps.
ReflectorSummary mirrors_summary(const Scene *scene, const Camera *camera, const RenderSettings *settings);

// What is near them, once the picture is rendered: counts over all reflectors, and what became of the rays.
typedef struct NearTotals {
  uint32_t cubes, listed, left_out, snapshots;
  uint64_t rays, counts[NEAR_COUNTS];
} NearTotals;
NearTotals mirrors_near(const Scene *scene, const Camera *camera, const RenderSettings *settings);

// Fails unless the picture is the same on every run, and however many rays are in flight.
void mirrors_assert_same_in_waves(const Scene *scene, const Camera *camera, const PictureRequest *request);
enum { MIRRORS_SIDE = 128 };

// A picture as displayed, and what became of its reflected rays where something was asked for them.
typedef struct MirrorsShown {
  float pixels[MIRRORS_SIDE * MIRRORS_SIDE][4];
  double rays, traced, shaded;  // asked, left to be traced, and left to be shaded
  ReflectorSummary reflectors;
  uint32_t planes, planes_left_out;
} MirrorsShown;

// To be freed.
MirrorsShown *mirrors_shown(const Scene *scene, const Camera *camera, ReflectionMethod method, uint32_t cube_px,
                            uint32_t lanes, uint32_t samples);

// Pixels whose worst channel differs by more than 2/255.
size_t mirrors_off(const MirrorsShown *a, const MirrorsShown *b);

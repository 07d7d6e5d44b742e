// Where rows of the catalogue are measured: scenes made in memory, rendered by the product's own passes.
#pragma once

#include "image/image.h"
#include "render/frame.h"
#include "scene/scene_build.h"

// The pictures of one measurement: [height][width], linear, alpha 1.
typedef struct LabPictures {
  Image method, reference;
} LabPictures;

typedef struct Lab {
  Device *device;
  bool quick;
  LabPictures pictures;  // of the last measurement that kept some
  Log *log;
} Lab;

void lab_pictures_free(LabPictures *pictures);

// What a frame holds once it is rendered.
typedef struct Shot {
  uint32_t width, height;
  CameraInfo camera;
  float *radiance;  // [height][width][4], linear
  float *values;    // [AOV_VALUE_PLANES][height][width]
  uint32_t *ids;    // [AOV_ID_PLANES][height][width]
} Shot;

void shot_free(Shot *shot);

static inline size_t shot_pixels(const Shot *shot) { return (size_t)shot->width * shot->height; }

// Position or normal of a pixel, `plane` being the first of its three of shared/aov.h.
Vec3 shot_vector(const Shot *shot, size_t pixel, int plane);

// One sample a pixel by rays, phong without an ambient term, no reflections: a white surface's radiance is its light.
RenderSettings lab_settings(uint32_t width, uint32_t height);

// Renders a scene that is on the device. Errors: those of frame_make and frame_render.
Status lab_render(Shot *out, Lab *lab, const DeviceScene *scene, const Camera *camera, const RenderSettings *settings);

// The same from a scene in memory.
Status lab_render_scene(Shot *out, Lab *lab, const Scene *scene, const Camera *camera, const RenderSettings *settings);

// What shadow maps state beforehand that they may put off, in pixels (render/shadow_bound.h); 0 for methods without
// maps and for hybrid shadows. Errors: those of frame_make and shadow_bound_make.
Status lab_shadow_bound(double *pixels, Lab *lab, const DeviceScene *scene, const Camera *camera,
                        const RenderSettings *settings);

// The share of the pixels that the cube map, or another map of reflections, is stated to put off beforehand
// (render/reflection_bound.h). Errors: those of frame_make and reflection_bound_make.
Status lab_reflection_bound(double *share, Lab *lab, const DeviceScene *scene, const Camera *camera,
                            const RenderSettings *settings);

// Makes copies the lab's pictures, from colours of `channels` (1: grey, 4: RGBA) floats a pixel. Errors:
// STATUS_NO_MEMORY.
Status lab_keep(Lab *lab, const float *method, const float *reference, uint32_t width, uint32_t height,
                uint32_t channels);

// As a display shows it: sRGB-encoded, clamped to [0, 1].
double lab_displayed(double linear);

// Do two values differ visibly: by more than 2/255 once displayed (sRGB)? What is not finite differs from all.
bool lab_differ(double a, double b);

// Pixels of two shots that differ visibly in R, G or B.
size_t lab_count_different(const Shot *a, const Shot *b);

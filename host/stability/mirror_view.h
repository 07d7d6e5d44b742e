// Scenes with mirrors in them, seen by a method and by rays.
#pragma once

#include "stability/lab.h"

// A mirror's material.
int mirror_view_material(Scene *scene, double reflectance);

// Six walls of different colours about the origin, that glow to the inside, 2.5 to 3.5 from it.
void mirror_view_walls(Scene *scene);

typedef struct MirrorView {
  ReflectionMethod method;
  uint32_t side_px, cube_px;
  float near_radius_m;  // 0: auto
} MirrorView;

// Renders with reflections by the view's method and by rays, and keeps both pictures. Errors: those of
// lab_render_scene.
Status mirror_view_render(Shot *by_method, Shot *by_rays, Lab *lab, const Scene *scene, const Camera *camera,
                          const MirrorView *view);

// Share of the pixels that show one thing in the first object which the method has wrong. `mixed` photographs what has
// a hundred triangles.
Status mirror_view_wrong(double *share, Lab *lab, const Scene *scene, const Camera *camera, ReflectionMethod method,
                         float near_radius_m);

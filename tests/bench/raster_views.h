// What both sides of the raster benchmark look at.
#pragma once

#include "bench/gl_peer.h"
#include "passes/raster_view.h"
#include "scene/scene.h"

typedef struct RasterViews {
  RasterView light, faces[6];
  GlView gl_light, gl_faces[6], gl_camera;
  float light_position[3], cube_center[3];
} RasterViews;

// A light from which the whole scene is seen, for maps of map_px; the faces of a cube halfway between the eye and the
// middle of the scene, of cube_px; the camera, which is in perspective. Both sides of a view draw the same.
void raster_views_aim(RasterViews *out, const Scene *scene, const CameraInfo *camera, uint32_t map_px,
                      uint32_t cube_px);

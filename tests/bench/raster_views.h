// What both sides of the raster benchmark look at, and the triangles as OpenGL takes them.
#pragma once

#include "bench/gl_peer.h"
#include "device_scene/flat_scene.h"
#include "passes/raster_view.h"

typedef struct RasterViews {
  RasterView light, faces[6];
  GlView gl_light, gl_faces[6], gl_camera;
  float light_position[3];
} RasterViews;

// A light from which the whole scene is seen, for maps of map_px; the faces of a cube halfway between the eye and the
// middle of the scene, of cube_px; the camera, which is in perspective. Both sides of a view draw the same.
void raster_views_aim(RasterViews *out, const Scene *scene, const CameraInfo *camera, uint32_t map_px,
                      uint32_t cube_px);

// Gives the peer the scene's triangles, with vertices at the same place welded to the first of them. Returns how many
// vertices are left.
uint32_t raster_peer_take(GlPeer *peer, const FlatScene *flat);

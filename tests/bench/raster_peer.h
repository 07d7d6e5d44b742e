// A scene as the OpenGL side of the raster benchmark takes it.
#pragma once

#include "bench/gl_peer.h"
#include "device_scene/flat_scene.h"

// Gives the peer the scene's triangles, with vertices at the same place welded to the first of them. Returns how many
// vertices are left.
uint32_t raster_peer_take(GlPeer *peer, const FlatScene *flat);

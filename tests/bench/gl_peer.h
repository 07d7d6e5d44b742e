// The stages of a raster frame by OpenGL ES 3 on a surfaceless EGL display: what the raster kernels are timed against.
// On a machine without a GPU that is Mesa's llvmpipe; LP_NUM_THREADS sets its threads.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct GlPeer GlPeer;

// A view: clip_from_world in column-major order, as OpenGL takes it.
typedef struct GlView {
  float clip_from_world[16];
} GlView;

// NULL, and a line on stderr, where there is no EGL display or OpenGL ES 3.
GlPeer *gl_peer_open(void);
void gl_peer_close(GlPeer *peer);
const char *gl_peer_name(const GlPeer *peer);

// World-space triangles, welded: [vertex_count][3] positions and normals, [triangle_count][3] indices.
void gl_peer_scene(GlPeer *peer, const float (*positions)[3], const float (*normals)[3], size_t vertex_count,
                   const uint32_t (*triangles)[3], size_t triangle_count);

// Each clears, draws all triangles without culling, waits for the end and returns milliseconds. The depth map is 32-bit
// float; the camera picture has 8-bit colour and 32-bit depth, diffuse light with 3 x 3 compares of the depth map
// (size_px must have been drawn before); the cube's six faces are like it without compares.
double gl_peer_depth_map(GlPeer *peer, uint32_t size_px, const GlView *view);
double gl_peer_camera(GlPeer *peer, uint32_t width, uint32_t height, const GlView *view, const GlView *light,
                      const float light_position[3]);
double gl_peer_cube(GlPeer *peer, uint32_t size_px, const GlView views[6], const float light_position[3]);

// The last camera picture, [height][width][4] from the bottom row up.
void gl_peer_read(GlPeer *peer, uint8_t *rgba);

// The stages of a raster frame by OpenGL ES 3.2 on a surfaceless EGL display: what the raster kernels are timed
// against. On a machine without a GPU that is Mesa's llvmpipe; LP_NUM_THREADS sets its threads.
#pragma once

#include <stddef.h>
#include <stdint.h>

typedef struct GlPeer GlPeer;

// A view: clip_from_world in column-major order, as OpenGL takes it. Row 0 of what is read back has clip y = -1.
typedef struct GlView {
  float clip_from_world[16];
} GlView;

#define GL_PEER_NOTHING 0xffffffffu  // the id of a pixel that shows no triangle

// NULL, and a line on stderr, where there is no EGL display or OpenGL ES 3.2.
GlPeer *gl_peer_open(void);
void gl_peer_close(GlPeer *peer);
const char *gl_peer_name(const GlPeer *peer);

// World-space triangles, welded: [vertex_count][3] positions and normals, [triangle_count][3] indices.
void gl_peer_scene(GlPeer *peer, const float (*positions)[3], const float (*normals)[3], size_t vertex_count,
                   const uint32_t (*triangles)[3], size_t triangle_count);

// Each clears and draws all triangles without culling, and returns when that is queued. Depth is 32-bit float. The cube
// is six depth maps; ids are the triangles' numbers; the shaded picture has 8-bit colour, diffuse light and 3 x 3
// compares of the depth map, which must have been drawn before. The first call of each size also makes what it draws
// into.
void gl_peer_depth_map(GlPeer *peer, uint32_t size_px, const GlView *view);
void gl_peer_cube(GlPeer *peer, uint32_t size_px, const GlView views[6]);
void gl_peer_ids(GlPeer *peer, uint32_t width, uint32_t height, const GlView *view);
void gl_peer_shaded(GlPeer *peer, uint32_t width, uint32_t height, const GlView *view, const GlView *light,
                    const float light_position[3]);

// Waits until all that is queued has been drawn.
void gl_peer_finish(GlPeer *peer);

// What was drawn last, [height][width].
void gl_peer_read_map(GlPeer *peer, float *depth);
void gl_peer_read_face(GlPeer *peer, int face, float *depth);
void gl_peer_read_ids(GlPeer *peer, uint32_t *ids, float *depth);

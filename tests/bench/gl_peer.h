// The stages of a raster frame by OpenGL ES 3.2 on a surfaceless EGL display: what the raster kernels are timed
// against. On a machine without a GPU that is Mesa's llvmpipe; LP_NUM_THREADS sets its threads.
#pragma once

#include <stdbool.h>
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

// World-space triangles, welded: [vertex_count][3] positions, [triangle_count][3] indices.
void gl_peer_scene(GlPeer *peer, const float (*positions)[3], size_t vertex_count, const uint32_t (*triangles)[3],
                   size_t triangle_count);

enum { GL_PEER_MATERIALS = 64, GL_PEER_TEXTURES = 4 };

// As std140 lays it out.
typedef struct GlMaterial {
  float base[4];      // linear
  float emission[4];  // linear radiance
  float metallic, roughness;
  float padding[2];
} GlMaterial;

typedef struct GlTexture {
  const uint8_t *texels;  // RGBA, sRGB, from the top left
  uint32_t width, height;
  bool nearest;
} GlTexture;

// Triangles that are drawn together.
typedef struct GlRange {
  size_t first, count;
} GlRange;

// The same triangles as they are shaded: vertices that differ in a normal, a texture coordinate or a material are not
// one. Textures repeat.
typedef struct GlSurfaces {
  const float (*positions)[3], (*normals)[3], (*uvs)[2];
  const float (*colors)[4];  // linear; NULL: white
  const uint32_t *material_of_vertex;
  size_t vertex_count;
  const uint32_t (*triangles)[3];
  size_t triangle_count;
  GlRange ranges[GL_PEER_TEXTURES + 1];  // without a texture of the base colour, then by texture
  const GlMaterial *materials;
  size_t material_count;
  const GlTexture *textures;
  size_t texture_count;
} GlSurfaces;
void gl_peer_surfaces(GlPeer *peer, const GlSurfaces *surfaces);

// A spot light of KHR_lights_punctual, without range.
typedef struct GlSpot {
  float position[3], direction[3];
  float candela;
  float scale, offset;  // attenuation = saturate(cos * scale + offset)^2
} GlSpot;

// Each clears and draws all triangles without culling, and returns when that is queued. Depth is 32-bit float. The cube
// is six depth maps; ids are the triangles' numbers. The first call of each size also makes what it draws into.
// What a depth map holds is moved away from the light by its growth over slope_texels.
void gl_peer_depth_map(GlPeer *peer, uint32_t size_px, const GlView *view, float slope_texels);
void gl_peer_cube(GlPeer *peer, uint32_t size_px, const GlView views[6]);
void gl_peer_ids(GlPeer *peer, uint32_t width, uint32_t height, const GlView *view);

// The picture by glTF's BRDF in RGBA of 16-bit floats: linear radiance, every side of a triangle seen; 3 x 3 compares
// of the depth map, each of them linear among four texels: a texel that the kernel covers in part counts in part. The
// map must have been drawn before.
void gl_peer_shaded(GlPeer *peer, uint32_t width, uint32_t height, const GlView *view, const float eye[3],
                    const GlView *light, const GlSpot *spot);
// The same of six square views from one eye, with their depths.
void gl_peer_captured(GlPeer *peer, uint32_t size_px, const GlView views[6], const float eye[3], const GlView *light,
                      const GlSpot *spot);

// Waits until all that is queued has been drawn.
void gl_peer_finish(GlPeer *peer);

// What was drawn last, [height][width].
void gl_peer_read_map(GlPeer *peer, float *depth);
void gl_peer_read_face(GlPeer *peer, int face, float *depth);
void gl_peer_read_ids(GlPeer *peer, uint32_t *ids, float *depth);
void gl_peer_read_shaded(GlPeer *peer, float (*radiance)[4]);

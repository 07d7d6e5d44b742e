#include "bench/gl_peer.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl32.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/gl_shaders.h"

// A framebuffer with a depth texture and, where it has a format, a colour one.
typedef struct Target {
  GLuint framebuffer, depth, color;
  GLenum format;  // GL_RGBA16F, GL_R32UI or 0
  uint32_t width, height;
} Target;

struct GlPeer {
  EGLDisplay display;
  EGLContext context;
  GLuint array, surface_array;
  GLsizei index_count;
  GLuint depth_program, id_program, surface_programs[2], copy_program;  // surfaces: without a texture, with one
  GLuint materials, textures[GL_PEER_TEXTURES];
  GlRange ranges[GL_PEER_TEXTURES + 1];
  Target map, camera, faces[6], captured[6], copy;
  char name[256];
};

static GLuint shader_compile(GLenum kind, const char *source)
{
  GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, NULL);
  glCompileShader(shader);
  GLint fine = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &fine);
  if (!fine) {
    char log[1024] = "";
    glGetShaderInfoLog(shader, sizeof log, NULL, log);
    fprintf(stderr, "gl_peer: %s\n", log);
    exit(1);
  }
  return shader;
}

static GLuint program_make(const char *vertex, const char *fragment)
{
  GLuint program = glCreateProgram();
  glAttachShader(program, shader_compile(GL_VERTEX_SHADER, vertex));
  glAttachShader(program, shader_compile(GL_FRAGMENT_SHADER, fragment));
  glLinkProgram(program);
  return program;
}

static GLuint surface_program_make(const char *head)
{
  char source[8192];
  int length = snprintf(source, sizeof source, "%s%s", head, surface_source);
  if (length >= (int)sizeof source) exit(1);
  return program_make(surface_vertex_source, source);
}

GlPeer *gl_peer_open(void)
{
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
      (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
  EGLDisplay display = get_display ? get_display(EGL_PLATFORM_SURFACELESS_MESA, NULL, NULL) : EGL_NO_DISPLAY;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL)) {
    fprintf(stderr, "gl_peer: no surfaceless EGL display: install libegl-mesa0 and libgl1-mesa-dri\n");
    return NULL;
  }
  eglBindAPI(EGL_OPENGL_ES_API);
  const EGLint config_wants[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_NONE};
  const EGLint context_wants[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 2, EGL_NONE};
  EGLConfig config;
  EGLint configs = 0;
  EGLContext context = EGL_NO_CONTEXT;
  if (eglChooseConfig(display, config_wants, &config, 1, &configs) && configs)
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, context_wants);
  if (context == EGL_NO_CONTEXT || !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    fprintf(stderr, "gl_peer: no OpenGL ES 3.2 context\n");
    eglTerminate(display);
    return NULL;
  }
  GlPeer *peer = calloc(1, sizeof *peer);
  if (!peer) exit(1);
  peer->display = display;
  peer->context = context;
  snprintf(peer->name, sizeof peer->name, "%s", (const char *)glGetString(GL_RENDERER));
  peer->depth_program = program_make(depth_vertex_source, depth_source);
  peer->id_program = program_make(id_vertex_source, id_source);
  peer->copy_program = program_make(cover_vertex_source, copy_source);
  peer->surface_programs[0] = surface_program_make("#version 320 es\n");
  peer->surface_programs[1] = surface_program_make("#version 320 es\n#define TEXTURED\n");
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glFrontFace(GL_CW);  // row 0 is the top one
  return peer;
}

void gl_peer_close(GlPeer *peer)
{
  if (!peer) return;
  eglDestroyContext(peer->display, peer->context);
  eglTerminate(peer->display);
  free(peer);
}

const char *gl_peer_name(const GlPeer *peer) { return peer->name; }

// A buffer of vertices, bound as the next attributes are told.
static void vertices_send(GLuint location, GLint size, const void *values, size_t vertex_count)
{
  GLuint buffer = 0;
  glGenBuffers(1, &buffer);
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(vertex_count * (size_t)size * sizeof(float)), values, GL_STATIC_DRAW);
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, 0, NULL);
}

static void triangles_send(const uint32_t (*triangles)[3], size_t triangle_count)
{
  GLuint buffer = 0;
  glGenBuffers(1, &buffer);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(triangle_count * sizeof *triangles), triangles, GL_STATIC_DRAW);
}

void gl_peer_scene(GlPeer *peer, const float (*positions)[3], size_t vertex_count, const uint32_t (*triangles)[3],
                   size_t triangle_count)
{
  glGenVertexArrays(1, &peer->array);
  glBindVertexArray(peer->array);
  vertices_send(0, 3, positions, vertex_count);
  triangles_send(triangles, triangle_count);
  peer->index_count = (GLsizei)(3 * triangle_count);
}

void gl_peer_surfaces(GlPeer *peer, const GlSurfaces *surfaces)
{
  glGenVertexArrays(1, &peer->surface_array);
  memcpy(peer->ranges, surfaces->ranges, sizeof peer->ranges);
  glBindVertexArray(peer->surface_array);
  vertices_send(0, 3, surfaces->positions, surfaces->vertex_count);
  vertices_send(1, 3, surfaces->normals, surfaces->vertex_count);
  vertices_send(2, 2, surfaces->uvs, surfaces->vertex_count);
  vertices_send(3, 1, surfaces->material_of_vertex, surfaces->vertex_count);
  glVertexAttribIPointer(3, 1, GL_UNSIGNED_INT, 0, NULL);
  glVertexAttrib4f(4, 1, 1, 1, 1);
  if (surfaces->colors) vertices_send(4, 4, surfaces->colors, surfaces->vertex_count);
  triangles_send(surfaces->triangles, surfaces->triangle_count);
  glGenBuffers(1, &peer->materials);
  glBindBuffer(GL_UNIFORM_BUFFER, peer->materials);
  glBufferData(GL_UNIFORM_BUFFER, GL_PEER_MATERIALS * sizeof *surfaces->materials, NULL, GL_STATIC_DRAW);
  glBufferSubData(GL_UNIFORM_BUFFER, 0, (GLsizeiptr)(surfaces->material_count * sizeof *surfaces->materials),
                  surfaces->materials);
  for (size_t i = 0; i < surfaces->texture_count; i++) {
    const GlTexture *texture = &surfaces->textures[i];
    GLint filter = texture->nearest ? GL_NEAREST : GL_LINEAR;
    glGenTextures(1, &peer->textures[i]);
    glBindTexture(GL_TEXTURE_2D, peer->textures[i]);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, (GLsizei)texture->width, (GLsizei)texture->height, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, texture->texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  }
}

static GLuint texture_make(GLenum format, uint32_t width, uint32_t height)
{
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexStorage2D(GL_TEXTURE_2D, 1, format, (GLsizei)width, (GLsizei)height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

// Makes the target of that size and format, unless it is there.
static void target_need(Target *target, uint32_t width, uint32_t height, GLenum format)
{
  if (target->width == width && target->height == height && target->format == format) return;
  glDeleteFramebuffers(1, &target->framebuffer);
  glDeleteTextures(1, &target->depth);
  glDeleteTextures(1, &target->color);
  *target = (Target){.width = width, .height = height, .format = format};
  target->depth = texture_make(GL_DEPTH_COMPONENT32F, width, height);
  if (format) target->color = texture_make(format, width, height);
  glGenFramebuffers(1, &target->framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, target->depth, 0);
  if (format) glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target->color, 0);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return;
  fprintf(stderr, "gl_peer: no framebuffer of %u x %u pixels\n", width, height);
  exit(1);
}

// Whether depth is compared with what a lookup brings, in proportion among four texels.
static void compare_set(GLuint depth, bool compared)
{
  GLint filter = compared ? GL_LINEAR : GL_NEAREST;
  glBindTexture(GL_TEXTURE_2D, depth);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, compared ? GL_COMPARE_REF_TO_TEXTURE : GL_NONE);
}

static void matrix_set(GLuint program, const char *name, const GlView *view)
{
  glUniformMatrix4fv(glGetUniformLocation(program, name), 1, GL_FALSE, view->clip_from_world);
}

static void target_clear(const Target *target)
{
  static const GLuint no_id[4] = {GL_PEER_NOTHING, 0, 0, 0};
  const GLfloat far_depth = 1;
  glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
  glViewport(0, 0, (GLsizei)target->width, (GLsizei)target->height);
  glClearBufferfv(GL_DEPTH, 0, &far_depth);
  if (target->format == GL_R32UI) glClearBufferuiv(GL_COLOR, 0, no_id);
  if (target->format == GL_RGBA16F) glClear(GL_COLOR_BUFFER_BIT);
}

static void target_draw(GlPeer *peer, const Target *target)
{
  target_clear(target);
  glDrawElements(GL_TRIANGLES, peer->index_count, GL_UNSIGNED_INT, NULL);
}

void gl_peer_depth_map(GlPeer *peer, uint32_t size_px, const GlView *view, float slope_texels)
{
  target_need(&peer->map, size_px, size_px, 0);
  glUseProgram(peer->depth_program);
  matrix_set(peer->depth_program, "clip_from_world", view);
  if (slope_texels > 0) glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(slope_texels, 1);
  target_draw(peer, &peer->map);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

void gl_peer_cube(GlPeer *peer, uint32_t size_px, const GlView views[6])
{
  glUseProgram(peer->depth_program);
  for (int face = 0; face < 6; face++) {
    target_need(&peer->faces[face], size_px, size_px, 0);
    matrix_set(peer->depth_program, "clip_from_world", &views[face]);
    target_draw(peer, &peer->faces[face]);
  }
}

void gl_peer_ids(GlPeer *peer, uint32_t width, uint32_t height, const GlView *view)
{
  target_need(&peer->camera, width, height, GL_R32UI);
  glUseProgram(peer->id_program);
  matrix_set(peer->id_program, "clip_from_world", view);
  target_draw(peer, &peer->camera);
}

// Draws the triangles of a range by the program for them.
static void range_draw(GlPeer *peer, int range, const GlView *view, const float eye[3], const GlView *light,
                       const GlSpot *spot)
{
  GLuint program = peer->surface_programs[range > 0];
  GlRange draw = peer->ranges[range];
  if (draw.count == 0) return;
  glUseProgram(program);
  matrix_set(program, "clip_from_world", view);
  matrix_set(program, "map_from_world", light);
  glUniform3fv(glGetUniformLocation(program, "eye"), 1, eye);
  glUniform3fv(glGetUniformLocation(program, "light_position"), 1, spot->position);
  glUniform3fv(glGetUniformLocation(program, "light_direction"), 1, spot->direction);
  glUniform3f(glGetUniformLocation(program, "light_numbers"), spot->candela, spot->scale, spot->offset);
  glUniform1f(glGetUniformLocation(program, "texel"), 1.0f / (float)peer->map.width);
  glUniform1i(glGetUniformLocation(program, "image"), 1);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, range > 0 ? peer->textures[range - 1] : 0);
  glActiveTexture(GL_TEXTURE0);
  glDrawElements(GL_TRIANGLES, (GLsizei)(3 * draw.count), GL_UNSIGNED_INT,
                 (const char *)NULL + 3 * draw.first * sizeof(uint32_t));
}

static void target_shade(GlPeer *peer, Target *target, uint32_t width, uint32_t height, const GlView *view,
                         const float eye[3], const GlView *light, const GlSpot *spot)
{
  target_need(target, width, height, GL_RGBA16F);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, peer->materials);
  glBindVertexArray(peer->surface_array);
  compare_set(peer->map.depth, true);
  target_clear(target);
  for (int range = 0; range <= GL_PEER_TEXTURES; range++) range_draw(peer, range, view, eye, light, spot);
  glBindVertexArray(peer->array);
}

void gl_peer_shaded(GlPeer *peer, uint32_t width, uint32_t height, const GlView *view, const float eye[3],
                    const GlView *light, const GlSpot *spot)
{
  target_shade(peer, &peer->camera, width, height, view, eye, light, spot);
}

void gl_peer_captured(GlPeer *peer, uint32_t size_px, const GlView views[6], const float eye[3], const GlView *light,
                      const GlSpot *spot)
{
  for (int face = 0; face < 6; face++)
    target_shade(peer, &peer->captured[face], size_px, size_px, &views[face], eye, light, spot);
}

void gl_peer_finish(GlPeer *peer) { glFinish(); }

// The first of four words of each pixel of the bound framebuffer.
static void words_read(uint32_t width, uint32_t height, uint32_t *out)
{
  uint32_t(*words)[4] = malloc((size_t)width * height * sizeof *words);
  if (!words) exit(1);
  glReadPixels(0, 0, (GLsizei)width, (GLsizei)height, GL_RGBA_INTEGER, GL_UNSIGNED_INT, words);
  for (size_t i = 0; i < (size_t)width * height; i++) out[i] = words[i][0];
  free(words);
}

static void depth_read(GlPeer *peer, const Target *target, float *out)
{
  target_need(&peer->copy, target->width, target->height, GL_R32UI);
  glBindFramebuffer(GL_FRAMEBUFFER, peer->copy.framebuffer);
  glUseProgram(peer->copy_program);
  glViewport(0, 0, (GLsizei)target->width, (GLsizei)target->height);
  glDisable(GL_DEPTH_TEST);
  compare_set(target->depth, false);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
  words_read(target->width, target->height, (uint32_t *)out);
}

void gl_peer_read_map(GlPeer *peer, float *depth) { depth_read(peer, &peer->map, depth); }

void gl_peer_read_face(GlPeer *peer, int face, float *depth) { depth_read(peer, &peer->faces[face], depth); }

void gl_peer_read_ids(GlPeer *peer, uint32_t *ids, float *depth)
{
  glBindFramebuffer(GL_FRAMEBUFFER, peer->camera.framebuffer);
  words_read(peer->camera.width, peer->camera.height, ids);
  depth_read(peer, &peer->camera, depth);
}

void gl_peer_read_shaded(GlPeer *peer, float (*radiance)[4])
{
  glBindFramebuffer(GL_FRAMEBUFFER, peer->camera.framebuffer);
  glReadPixels(0, 0, (GLsizei)peer->camera.width, (GLsizei)peer->camera.height, GL_RGBA, GL_FLOAT, radiance);
}

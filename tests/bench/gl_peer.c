#include "bench/gl_peer.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl32.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A framebuffer with a depth texture and, where it has a format, a colour one.
typedef struct Target {
  GLuint framebuffer, depth, color;
  GLenum format;  // GL_RGBA8, GL_R32UI or 0
  uint32_t width, height;
} Target;

struct GlPeer {
  EGLDisplay display;
  EGLContext context;
  GLuint vertices, indices, array;
  GLsizei index_count;
  GLuint depth_program, id_program, shadowed_program, copy_program;
  Target map, camera, faces[6], copy;
  char name[256];
};

static const char *const vertex_source =
    "#version 300 es\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "uniform mat4 clip_from_world;\n"
    "out vec3 world_position;\n"
    "out vec3 world_normal;\n"
    "void main() {\n"
    "  world_position = position;\n"
    "  world_normal = normal;\n"
    "  gl_Position = clip_from_world * vec4(position, 1.0);\n"
    "}\n";

static const char *const depth_vertex_source =
    "#version 300 es\n"
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 clip_from_world;\n"
    "void main() { gl_Position = clip_from_world * vec4(position, 1.0); }\n";

static const char *const depth_source = "#version 300 es\nvoid main() {}\n";

static const char *const id_vertex_source =
    "#version 320 es\n"
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 clip_from_world;\n"
    "void main() { gl_Position = clip_from_world * vec4(position, 1.0); }\n";

static const char *const id_source =
    "#version 320 es\n"
    "precision highp int;\n"
    "out uint id;\n"
    "void main() { id = uint(gl_PrimitiveID); }\n";

// A triangle over the whole target, and the bits of a depth texture as colour.
static const char *const cover_vertex_source =
    "#version 300 es\n"
    "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0.0, 1.0); }\n";

static const char *const copy_source =
    "#version 300 es\n"
    "precision highp float;\n"
    "precision highp int;\n"
    "uniform highp sampler2D depth;\n"
    "out highp uint bits;\n"
    "void main() { bits = floatBitsToUint(texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r); }\n";

static const char *const shadowed_source =
    "#version 300 es\n"
    "precision highp float;\n"
    "precision highp sampler2DShadow;\n"
    "in vec3 world_position;\n"
    "in vec3 world_normal;\n"
    "uniform vec3 light_position;\n"
    "uniform mat4 map_from_world;\n"
    "uniform sampler2DShadow map;\n"
    "uniform float texel;\n"
    "out vec4 color;\n"
    "void main() {\n"
    "  vec3 n = normalize(world_normal), l = normalize(light_position - world_position);\n"
    "  vec4 clip = map_from_world * vec4(world_position, 1.0);\n"
    "  vec3 at = 0.5 * clip.xyz / clip.w + 0.5;\n"
    "  float lit = 0.0;\n"
    "  for (int y = -1; y <= 1; y++)\n"
    "    for (int x = -1; x <= 1; x++) lit += texture(map, vec3(at.xy + texel * vec2(x, y), at.z - 0.0005));\n"
    "  color = vec4(vec3(0.1 + 0.1 * lit * abs(dot(n, l))), 1.0);\n"
    "}\n";

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
  peer->shadowed_program = program_make(vertex_source, shadowed_source);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
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

void gl_peer_scene(GlPeer *peer, const float (*positions)[3], const float (*normals)[3], size_t vertex_count,
                   const uint32_t (*triangles)[3], size_t triangle_count)
{
  size_t bytes = vertex_count * sizeof *positions;
  glGenVertexArrays(1, &peer->array);
  glBindVertexArray(peer->array);
  glGenBuffers(1, &peer->vertices);
  glBindBuffer(GL_ARRAY_BUFFER, peer->vertices);
  glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(2 * bytes), NULL, GL_STATIC_DRAW);
  glBufferSubData(GL_ARRAY_BUFFER, 0, (GLsizeiptr)bytes, positions);
  glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)bytes, (GLsizeiptr)bytes, normals);
  glGenBuffers(1, &peer->indices);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, peer->indices);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(triangle_count * sizeof *triangles), triangles, GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 0, (const char *)NULL + bytes);
  peer->index_count = (GLsizei)(3 * triangle_count);
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

// Whether depth is compared with what a lookup brings.
static void compare_set(GLuint depth, bool compared)
{
  glBindTexture(GL_TEXTURE_2D, depth);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, compared ? GL_COMPARE_REF_TO_TEXTURE : GL_NONE);
}

static void matrix_set(GLuint program, const char *name, const GlView *view)
{
  glUniformMatrix4fv(glGetUniformLocation(program, name), 1, GL_FALSE, view->clip_from_world);
}

static void target_draw(GlPeer *peer, const Target *target)
{
  static const GLuint no_id[4] = {GL_PEER_NOTHING, 0, 0, 0};
  const GLfloat far_depth = 1;
  glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
  glViewport(0, 0, (GLsizei)target->width, (GLsizei)target->height);
  glClearBufferfv(GL_DEPTH, 0, &far_depth);
  if (target->format == GL_R32UI) glClearBufferuiv(GL_COLOR, 0, no_id);
  if (target->format == GL_RGBA8) glClear(GL_COLOR_BUFFER_BIT);
  glDrawElements(GL_TRIANGLES, peer->index_count, GL_UNSIGNED_INT, NULL);
}

void gl_peer_depth_map(GlPeer *peer, uint32_t size_px, const GlView *view)
{
  target_need(&peer->map, size_px, size_px, 0);
  glUseProgram(peer->depth_program);
  matrix_set(peer->depth_program, "clip_from_world", view);
  target_draw(peer, &peer->map);
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

void gl_peer_shaded(GlPeer *peer, uint32_t width, uint32_t height, const GlView *view, const GlView *light,
                    const float light_position[3])
{
  GLuint program = peer->shadowed_program;
  target_need(&peer->camera, width, height, GL_RGBA8);
  glUseProgram(program);
  matrix_set(program, "clip_from_world", view);
  matrix_set(program, "map_from_world", light);
  glUniform3fv(glGetUniformLocation(program, "light_position"), 1, light_position);
  glUniform1f(glGetUniformLocation(program, "texel"), 1.0f / (float)peer->map.width);
  compare_set(peer->map.depth, true);
  target_draw(peer, &peer->camera);
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

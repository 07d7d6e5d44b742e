// Runs every kernel on scene_features at one lane width, for a simulator that watches each access (scripts/oclgrind).
//
// Usage: render_features LANES WIDTHxHEIGHT   LANES: 16, 8 (both as for CPUs) or 1 (as for GPUs)
//
// The picture itself is not looked at: other tests do that.

#include <CL/cl.h>
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "device_scene/solid.h"
#include "passes/cube_lit.h"
#include "passes/raster_depth.h"
#include "passes/raster_visibility.h"
#include "passes/sure_maps.h"
#include "render/shadow_bound.h"
#include "scene/scene_build.h"
#include "shared/stream.h"
#include "support/picture_fixture.h"
#include "support/scene_features.h"

// The calls below stand in for OpenCL's own, for the sake of Oclgrind 21.10's check for uninitialised values. To that a
// store from the host is the whole buffer, of which it forgets all else: where it is a step of a fill, or lies at an
// offset, what was there counts as never written (Uninitialized::hostMemoryStore calls ShadowMemory::allocate). So
// parts are filled by a kernel. And a new buffer holds what an old one at its address did.

static bool starts_as_nan;

static cl_int buffer_set(cl_command_queue queue, cl_mem buffer, size_t bytes, const void *pattern, size_t pattern_bytes)
{
  char *values = malloc(bytes);
  if (!values) return CL_OUT_OF_HOST_MEMORY;
  for (size_t at = 0; at < bytes; at += pattern_bytes) memcpy(values + at, pattern, pattern_bytes);
  cl_int error = clEnqueueWriteBuffer(queue, buffer, CL_TRUE, 0, bytes, values, 0, NULL, NULL);
  free(values);
  return error;
}

// Sets each `stride`-th word from the `first` on.
static cl_int words_set(cl_command_queue queue, cl_mem buffer, cl_uint first, cl_uint stride, size_t count,
                        cl_uint word)
{
  static const char *source =
      "kernel void set(global uint *to, uint first, uint stride, uint word)"
      "{ to[first + stride * get_global_id(0)] = word; }";
  static cl_kernel kernel;
  cl_int error = CL_SUCCESS;
  if (!kernel) {
    cl_context context;
    clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof context, &context, NULL);
    cl_program program = clCreateProgramWithSource(context, 1, &source, NULL, &error);
    if (error == CL_SUCCESS) error = clBuildProgram(program, 0, NULL, "", NULL, NULL);
    if (error == CL_SUCCESS) kernel = clCreateKernel(program, "set", &error);
    if (error != CL_SUCCESS) return error;
  }
  clSetKernelArg(kernel, 0, sizeof buffer, &buffer);
  clSetKernelArg(kernel, 1, sizeof first, &first);
  clSetKernelArg(kernel, 2, sizeof stride, &stride);
  clSetKernelArg(kernel, 3, sizeof word, &word);
  return clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &count, NULL, 0, NULL, NULL);
}

// Lanes past the end of a stream load what nobody has written, and are masked: to the check that is use. So for vectors
// buffers start as NaNs, which may not reach the picture.
cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void *initial, cl_int *error)
{
  cl_mem (*create)(cl_context, cl_mem_flags, size_t, void *, cl_int *);
  cl_device_id device;
  *(void **)&create = dlsym(RTLD_NEXT, __func__);
  cl_mem buffer = create(context, flags, bytes, initial, error);
  if (!buffer || !starts_as_nan) return buffer;
  clGetContextInfo(context, CL_CONTEXT_DEVICES, sizeof device, &device, NULL);
  cl_command_queue queue = clCreateCommandQueue(context, device, 0, error);
  if (*error == CL_SUCCESS) *error = buffer_set(queue, buffer, bytes, "\xff", 1);
  clReleaseCommandQueue(queue);
  return buffer;
}

cl_int clReleaseMemObject(cl_mem buffer) { return CL_SUCCESS; }

cl_int clEnqueueFillBuffer(cl_command_queue queue, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                           size_t offset, size_t bytes, cl_uint wait_count, const cl_event *wait_events,
                           cl_event *event)
{
  size_t whole;
  cl_uint words[32];  // the longest pattern
  const size_t word = sizeof *words;
  clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof whole, &whole, NULL);
  if (bytes == whole) return buffer_set(queue, buffer, bytes, pattern, pattern_bytes);
  if (offset % word || bytes % word) return CL_INVALID_VALUE;
  cl_int error = CL_SUCCESS;
  const cl_uint stride = (cl_uint)(pattern_bytes < word ? 1 : pattern_bytes / word);
  for (size_t at = 0; at < stride * word; at += pattern_bytes) memcpy((char *)words + at, pattern, pattern_bytes);
  for (cl_uint i = 0; i < stride && error == CL_SUCCESS; i++)
    error = words_set(queue, buffer, (cl_uint)(offset / word) + i, stride, bytes / word / stride, words[i]);
  return error;
}

// Every branch of the resolve kernel.
static Status sums_resolve(Frame *frame, uint32_t pixels)
{
  static const ResolveInfo infos[] = {
      {.scale = 1, .coverage_scale = 1},
      {.scale = 2, .coverage_scale = 1, .display = 1, .tone = TONE_CURVE_FILMIC},
      {.scale = 4, .coverage_scale = 1, .display = 1, .tone = TONE_CURVE_PBR_NEUTRAL, .opaque = 1, .has_background = 1},
  };
  Status status = STATUS_OK;
  float *values = calloc(pixels, 4 * sizeof *values);
  for (size_t i = 0; i < sizeof infos / sizeof *infos; i++) {
    ResolveInfo info = infos[i];
    info.pixel_count = pixels;
    TRY(film_resolve(&frame->film, frame->device, &frame->film.sums, &info, values, &picture_log));
    for (uint32_t k = 0; k < 4 * pixels; k++)
      if (!isfinite(values[k])) {
        status = log_fail(&picture_log, STATUS_FAILED, "picture %zu: value %u is %g", i, k, values[k]);
        goto done;
      }
  }

done:
  free(values);
  return status;
}

static Status render(Device *device, const Scene *scene, const RenderSettings *settings, uint32_t aovs)
{
  Status status = STATUS_OK;
  DeviceScene device_scene = {0};
  Frame frame = {0};
  ShadowBound bound = {0};
  Camera camera = scene_features_camera();
  TRY(device_scene_make(&device_scene, device, scene, NULL, &picture_log));
  SceneFacts facts = {.light_count = device_scene.light_count,
                      .has_mirrors = device_scene.has_mirrors,
                      .has_blends = device_scene.has_blends,
                      .environment_lights = device_scene.environment_lights};
  FrameRequest request = {.camera = &camera,
                          .area = {settings->width, settings->height, 0, 0, settings->width, settings->height},
                          .samples = settings->samples,
                          .plan = plan_make(settings, &facts),
                          .aovs = aovs};
  TRY(frame_make(&frame, device, &device_scene, &request, &picture_log));
  TRY(frame_render(&frame, &picture_log));
  if (frame.shadow_maps.light_count) TRY(shadow_bound_make(&bound, &frame, 1, &picture_log));
  TRY(sums_resolve(&frame, settings->width * settings->height));

done:
  shadow_bound_free(&bound);
  frame_free(&frame);
  device_scene_free(&device_scene);
  return status;
}

// What the camera sees, as a GPU draws it: triangles of every size.
static Status visibility_direct(Device *device, const DeviceScene *scene)
{
  Status status = STATUS_OK;
  const RasterOptions options = {.way = RASTER_WAY_DIRECT};
  const Camera camera = scene_features_camera();
  const CameraInfo info = camera_info(&camera, &(PictureArea){64, 36, 0, 0, 64, 36});
  const Wave wave = {0, info.tiles_per_row * ((info.height + TILE_SIZE - 1) / TILE_SIZE), 0, 1};
  uint32_t count = wave_rays(&wave);
  CameraRays rays = {0};
  RasterScene triangles = {0};
  RasterVisibility raster = {0};
  HitStream hits = {0};
  TRY(camera_rays_make(&rays, device, &info, 1, &picture_log));
  TRY(raster_scene_make(&triangles, device, scene, &options, &picture_log));
  TRY(raster_visibility_make(&raster, device, scene, &options, &picture_log));
  TRY(raster_visibility_aim(&raster, device, &triangles, &rays, 1, count, &picture_log));
  TRY(hit_stream_make(&hits, device, count, &picture_log));
  TRY(raster_visibility(&raster, device, scene, &triangles, &rays, &wave, &hits, count, &picture_log));
  TRY(device_finish(device, &picture_log));

done:
  camera_rays_free(&rays);
  raster_scene_free(&triangles);
  raster_visibility_free(&raster);
  hit_stream_free(&hits);
  return status;
}

// Maps of the scene from the front, in parallel, and from its middle, where triangles reach behind the eye.
static Status depth_maps(Device *device, const DeviceScene *scene, RasterWay way)
{
  enum { SIZE = 64, VIEWS = 2 };
  Status status = STATUS_OK;
  const RasterOptions options = {.way = way};
  static const Mat4 from_front = {{0.1, 0, 0, 0, 0, -0.1, 0, 0, 0, 0, -0.05, 0, 0.5, 0.7, 0.5, 1}};
  static const Mat4 from_middle = {{0.5, 0, 0, 0, 0, 0.5, 0, 0, 0.5, 0.5, 1, 1, 0, -0.25, -0.1, 0}};
  const RasterView views[VIEWS] = {raster_view_of_map(&from_front, vec3(0, 1, 0), SIZE, 0),
                                   raster_view_of_map(&from_middle, vec3(0, 0.5, 0), SIZE, 0.05)};
  RasterScene triangles = {0};
  RasterDepth raster = {0};
  float maps[SIZE * SIZE * VIEWS];
  TRY(raster_scene_make(&triangles, device, scene, &options, &picture_log));
  TRY(raster_depth_make(&raster, device, scene, &options, &picture_log));
  TRY(raster_depth(&raster, device, scene, &triangles, views, VIEWS, &picture_log));
  TRY(buffer_read(device, &raster.maps, maps, sizeof maps, &picture_log));
  for (int i = 0; i < SIZE * SIZE * VIEWS; i++)
    if (!(maps[i] >= 0 && maps[i] <= 1)) {
      status = log_fail(&picture_log, STATUS_FAILED, "depth maps: value %d is %g", i, maps[i]);
      goto done;
    }

done:
  raster_scene_free(&triangles);
  raster_depth_free(&raster);
  return status;
}

// What the maps of a point light know for sure, as a GPU draws them.
static Status sure_maps_direct(Device *device, const DeviceScene *scene)
{
  Status status = STATUS_OK;
  const RasterOptions options = {.way = RASTER_WAY_DIRECT};
  const ShadowOptions shadow_options = {.map_size_px = 16};
  const Camera camera = scene_features_camera();
  const CameraInfo info = camera_info(&camera, &(PictureArea){64, 36, 0, 0, 64, 36});
  const ShadowScope scope = {&info, scene->low, scene->high};
  ShadowFit fit;
  Solids solids = {0};
  RasterScene triangles = {0};
  SureRaster raster = {0};
  SureMaps maps = {0};
  DeviceBuffer solid = {0};
  bool lit = false;
  for (uint32_t i = 0; i < scene->light_count && !lit; i++)
    lit = scene->light_infos[i].kind == LIGHT_KIND_POINT &&
          shadow_fit(&fit, &scene->light_infos[i], SHADOWS_HYBRID, &shadow_options, &scope);
  if (!lit) return log_fail(&picture_log, STATUS_FAILED, "sure maps: the scene has no point light");
  TRY(solids_make(&solids, scene->source, &picture_log));
  TRY(buffer_create(&solid, device, solids.word_count * sizeof *solids.bits, solids.bits, "solid", &picture_log));
  TRY(raster_scene_make(&triangles, device, scene, &options, &picture_log));
  TRY(sure_raster_make(&raster, device, &triangles, &options, &picture_log));
  TRY(sure_maps_aim(&maps, device, &fit, 1, false, &picture_log));
  TRY(sure_maps_settle(&maps, device, NULL, NULL, &picture_log));
  TRY(sure_maps_draw(&maps, 0, &raster, device, &triangles, &solid, SURE_MARKED_SOLID, &picture_log));
  TRY(device_finish(device, &picture_log));

done:
  solids_free(&solids);
  buffer_free(&solid);
  raster_scene_free(&triangles);
  sure_raster_free(&raster);
  sure_maps_free(&maps);
  return status;
}

// Which faces of a cube map the scene's lights shine on.
static Status faces_lit(Device *device, const DeviceScene *scene)
{
  enum { SIZE = 4 };
  static float texels[CUBE_TEXELS(SIZE)][4];
  Status status = STATUS_OK;
  const CubeInfo cube = {.size = SIZE};
  CubeLit lit = {0};
  DeviceBuffer buffer = {0};
  uint32_t faces;
  for (int i = 0; i < CUBE_TEXELS(SIZE); i++) texels[i][3] = i % 3 ? 0.5f : 0;
  TRY(buffer_create(&buffer, device, sizeof texels, texels, "texels", &picture_log));
  TRY(cube_lit_make(&lit, device, scene->light_infos, scene->light_count, &picture_log));
  TRY(cube_lit_find(&faces, &lit, device, &cube, &buffer, 1e-5f, &picture_log));

done:
  buffer_free(&buffer);
  cube_lit_free(&lit);
  return status;
}

int main(int argc, char **argv)
{
  static const float colors[4][3] = {{1, 1, 1}, {0.5f, 0.6f, 1}, {0.2f, 0.2f, 0.1f}, {3, 2, 1}};
  static const uint8_t mixed[] = {SHADOWS_HYBRID, SHADOWS_PCSS, SHADOWS_AREA, SHADOWS_MAP, SHADOWS_NONE, SHADOWS_PCF};
  static const uint8_t quick[] = {SHADOWS_PCF, SHADOWS_HYBRID, SHADOWS_PCF, SHADOWS_PCF, SHADOWS_NONE, SHADOWS_HYBRID};
  Status status = STATUS_OK;
  Scene scene = scene_features();
  DeviceScene device_scene = {0};
  PictureRequest request = picture_request(0, 0, 1);
  RenderSettings *settings = &request.settings;
  if (argc != 3 || sscanf(argv[2], "%ux%u", &settings->width, &settings->height) != 2) {
    fputs("usage: render_features LANES WIDTHxHEIGHT\n", stderr);
    return 2;
  }
  scene.objects[1].shadowless = true;
  uint32_t lanes = (uint32_t)atoi(argv[1]);
  starts_as_nan = lanes > 1;
  Device *device = picture_device(lanes);
  settings->max_depth = 3;  // from the third bounce on, a CPU walks single rays
  TRY(render(device, &scene, settings, AOV_SET_SURFACE | AOV_SET_SHADOW | AOV_SET_REFLECTION));

  settings->lighting = LIGHTING_PHONG;
  settings->max_depth = 1;
  settings->shadows = SHADOWS_NONE;
  settings->primary = PRIMARY_RASTER;
  scene_set_image(&scene, 2, 2, colors);
  TRY(render(device, &scene, settings, AOV_SET_NONE));

  // Small maps: the kernels see every kind of texel in them. A minute of the smallest picture is spent on two
  // methods; LANES 8 is left out, for to its check what masked lanes look up is use.
  bool small = settings->width < 64;
  settings->shadow_options = (ShadowOptions){
      .map_size_px = lanes == 1 ? 16 : 64, .kernel_px = 3, .light_radius_m = 0.2f, .light_angle_rad = 0.02};
  settings->width = settings->width < 16 ? settings->width : 16;
  settings->height = settings->height < 9 ? settings->height : 9;
  for (ShadowMethod method = SHADOWS_MAP; method <= SHADOWS_AREA; method++) {
    settings->shadows = method;
    if (!small && lanes != 8 && method != SHADOWS_RAYS) TRY(render(device, &scene, settings, AOV_SET_NONE));
  }
  settings->light_shadows = small ? quick : mixed;
  if (small ? lanes == 16 : lanes != 8) TRY(render(device, &scene, settings, AOV_SET_NONE));
  settings->light_shadows = NULL;

  settings->shadows = SHADOWS_NONE;
  settings->cubes.size_px = lanes == 1 ? 8 : 16;
  for (ReflectionMethod method = REFLECTIONS_ENVIRONMENT; method < REFLECTIONS_RAYS; method++) {
    settings->reflections = method;
    bool first = method == REFLECTIONS_IMPOSTOR || method == REFLECTIONS_SNAPSHOT || method == REFLECTIONS_PLANAR ||
                 method == REFLECTIONS_HYBRID;
    if (small ? lanes == 16 && first : lanes != 8) TRY(render(device, &scene, settings, AOV_SET_NONE));
  }

  // Rough surfaces, by the one cube that there is room for: prefiltering takes a while.
  settings->lighting = LIGHTING_PBR;
  settings->max_roughness = 1;
  settings->reflections = REFLECTIONS_IMPOSTOR;
  settings->cubes = (CubeOptions){.size_px = 8, .max_bytes = 27000};
  if (!small && lanes != 8) TRY(render(device, &scene, settings, AOV_SET_NONE));

  TRY(device_scene_make(&device_scene, device, &scene, NULL, &picture_log));
  TRY(depth_maps(device, &device_scene, RASTER_WAY_BINS));
  if (lanes == 1) {
    TRY(depth_maps(device, &device_scene, RASTER_WAY_DIRECT));
    TRY(visibility_direct(device, &device_scene));
    TRY(sure_maps_direct(device, &device_scene));
    TRY(faces_lit(device, &device_scene));
  }

done:
  if (status) fprintf(stderr, "render_features: status %d: %s\n", status, picture_log.error);
  device_scene_free(&device_scene);
  scene_free(&scene);
  device_close(device);
  return status != STATUS_OK;
}

#include "bench/raster_stages.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "passes/cube_capture.h"
#include "shared/depth_map.h"
#include "shared/raster.h"
#include "shared/stream.h"

enum { FRAME_MAP_PX = 2048, FRAME_MAP_WORDS = FRAME_MAP_PX * FRAME_MAP_PX / 64 * 81 + 16 };

const uint32_t map_px[MAPS] = {1024, FRAME_MAP_PX}, capture_px[CAPTURES] = {256, 512};
const char *const stage_names[STAGES] = {"depth map 1024",   "depth map 2048",     "cube 6 x 256",
                                         "visibility 1080p", "shaded 1080p + PCF", "whole frame",
                                         "capture 6 x 256",  "capture 6 x 512",    "frame and cube"};

static Status depth_draw(RasterStages *stages, RasterDepth *raster, const RasterView *views, uint32_t count)
{
  return raster_depth(raster, stages->base.device, &stages->base.device_scene, &stages->triangles, views, count,
                      &stages->base.log);
}

// The light's view of a map.
static RasterView light_view(const RasterStages *stages, int map)
{
  RasterView view = stages->views.light;
  for (Float4 *row = &view.x; row <= &view.y; row++) {  // rows are in texels
    float scale = (float)map_px[map] / (float)map_px[0];
    *row = (Float4){row->x * scale, row->y * scale, row->z * scale, row->w * scale};
  }
  view.width = view.height = map_px[map];
  return view;
}

static Status map_draw(RasterStages *stages, int map)
{
  const RasterView view = light_view(stages, map);
  return depth_draw(stages, &stages->maps[map], &view, 1);
}

// All maps at once, as host/passes/shadow_maps.c does.
static Status frame_maps_draw(RasterStages *stages, bool with_cube)
{
  enum { FACES = 6 };
  Status status = STATUS_OK;
  Device *device = stages->base.device;
  const DeviceScene *scene = &stages->base.device_scene;
  RasterView views[1 + FACES] = {light_view(stages, 1)};
  for (uint32_t i = 0; i < FACES; i++) {
    views[1 + i] = stages->views.faces[i];
    views[1 + i].first_texel = FRAME_MAP_WORDS + i * CUBE_PX * CUBE_PX;
  }
  TRY(raster_depth_into(&stages->maps[1], device, scene, &stages->triangles, views, with_cube ? 1 + FACES : 1,
                        &stages->frame_maps, &stages->base.log));
  if (device_traits(device)->lanes > 1)
    TRY(raster_depth_planes(device, scene, &stages->frame_maps, 0, map_px[1], 1, &stages->base.log));

done:
  return status;
}

static Status visibility_draw(RasterStages *stages)
{
  Status status = STATUS_OK;
  Wave wave = {0, stages->tiles, 0, 1};
  uint32_t capacity = stages->tiles * TILE_PIXELS;
  TRY(raster_visibility_aim(&stages->visibility, stages->base.device, &stages->triangles, &stages->camera, 1, capacity,
                            &stages->base.log));
  TRY(raster_visibility(&stages->visibility, stages->base.device, &stages->base.device_scene, &stages->triangles,
                        &stages->camera, &wave, &stages->hits, capacity, &stages->base.log));

done:
  return status;
}

// Radiance by slot of all faces, and what the hits keep of their depth.
static Status capture_draw(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  uint32_t tiles = frame->camera.info.tiles_per_row * camera_tile_rows(&frame->camera);
  uint32_t most = frame_wave_tiles(frame, tiles, 1);
  TRY(raster_visibility_aim(&frame->raster, frame->device, &frame->raster_scene, &frame->camera, 1, frame->capacity,
                            log));
  for (uint32_t tile = 0; tile < tiles; tile += most) {
    Wave wave = {tile, tiles - tile < most ? tiles - tile : most, 0, 1};
    TRY(frame_render_wave(frame, &wave, log));
  }

done:
  return status;
}

Status raster_stage_run(RasterStages *stages, Stage stage)
{
  Status status = STATUS_OK;
  Log *log = &stages->base.log;
  if (stage == MAP_1024 || stage == MAP_2048) TRY(map_draw(stages, stage == MAP_2048));
  if (stage == CUBE) TRY(depth_draw(stages, &stages->cube, stages->views.faces, 6));
  const bool with_cube = stage == FRAME_AND_CUBE, whole = with_cube || stage == FRAME;
  if (whole) TRY(frame_maps_draw(stages, with_cube));
  if (stage == VISIBILITY) TRY(visibility_draw(stages));
  if (stage == SHADED || whole) TRY(frame_render(&stages->frame, log));
  if (stage == CAPTURE_256 || stage == CAPTURE_512) TRY(capture_draw(&stages->captures[stage - CAPTURE_256], log));
  TRY(device_finish(stages->base.device, log));

done:
  return status;
}

// The same frame for a camera of six views.
static Status capture_prepare(Frame *out, RasterStages *stages, const FrameRequest *request, uint32_t size)
{
  Status status = STATUS_OK;
  Device *device = stages->base.device;
  Log *log = &stages->base.log;
  CameraInfo views[6];
  const float center[1][2] = {{0.5f, 0.5f}};
  const RasterOptions options = {0};
  TRY(frame_make(out, device, &stages->lit_scene, request, log));
  cube_cameras(views, size, vec3_from_floats(stages->views.cube_center),
               (float)(4e-5 * stages->base.device_scene.extent_m));
  camera_rays_free(&out->camera);
  TRY(camera_rays_make_views(&out->camera, device, views, 6, center, 1, log));
  raster_visibility_free(&out->raster);
  TRY(raster_visibility_make(&out->raster, device, &stages->lit_scene, &options, log));

done:
  return status;
}

// A frame of the scene under one light, which stands where the peer's does and sees as much.
static Status frame_prepare(RasterStages *stages)
{
  Status status = STATUS_OK;
  Scene *scene = &stages->base.scene, kept = *scene;
  Vec3 low, high, at = vec3_from_floats(stages->views.light_position);
  scene_bounds(scene, &low, &high);
  Vec3 middle = vec3_scale(vec3_add(low, high), 0.5);
  Light light = {.kind = LIGHT_SPOT,
                 .color = {1, 1, 1},
                 .intensity = (float)(10 * vec3_dot(vec3_sub(at, middle), vec3_sub(at, middle))),
                 .range_m = INFINITY,
                 .inner_cone_rad = M_PI / 7,
                 .outer_cone_rad = M_PI / 6,
                 .position_world = at,
                 .direction_world = vec3_unit_or(vec3_sub(middle, at), vec3(0, -1, 0))};
  RenderSettings settings = {.samples = 1,
                             .primary = PRIMARY_RASTER,
                             .shadows = SHADOWS_PCF,
                             .shadow_options = {.map_size_px = 2048, .kernel_px = 3}};
  SceneFacts facts = {.triangle_count = stages->triangles.triangle_count, .pixel_count = PIXELS, .light_count = 1};
  FrameRequest request = {.camera = &stages->base.camera,
                          .area = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT},
                          .samples = 1,
                          .plan = plan_make(&settings, &facts)};
  scene->lights = &light;
  scene->light_count = 1;
  TRY(device_scene_make(&stages->lit_scene, stages->base.device, scene, NULL, &stages->base.log));
  TRY(frame_make(&stages->frame, stages->base.device, &stages->lit_scene, &request, &stages->base.log));
  for (int i = 0; i < CAPTURES; i++) TRY(capture_prepare(&stages->captures[i], stages, &request, capture_px[i]));

done:
  *scene = kept;
  return status;
}

static Status passes_make(RasterStages *stages)
{
  Status status = STATUS_OK;
  const RasterOptions usual = {0};
  Device *device = stages->base.device;
  const DeviceScene *scene = &stages->base.device_scene;
  Log *log = &stages->base.log;
  PictureArea area = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT};
  CameraInfo info = camera_info(&stages->base.camera, &area);
  if (info.orthographic)
    return log_fail(log, STATUS_USAGE, "benchmark: the camera is orthographic: use a file whose first one is not");
  info.far_m = INFINITY;  // as in OpenGL's matrix above
  stages->tiles = info.tiles_per_row * (HEIGHT / TILE_SIZE);
  TRY(raster_scene_make(&stages->triangles, device, scene, &usual, log));
  for (int i = 0; i < MAPS; i++) TRY(raster_depth_make(&stages->maps[i], device, scene, &usual, log));
  const size_t words = FRAME_MAP_WORDS + 6 * CUBE_PX * CUBE_PX;
  TRY(buffer_create(&stages->frame_maps, device, words * sizeof(float), NULL, "depth maps", log));
  TRY(raster_depth_make(&stages->cube, device, scene, &usual, log));
  TRY(raster_visibility_make(&stages->visibility, device, scene, &usual, log));
  TRY(camera_rays_make(&stages->camera, device, &info, 1, log));
  TRY(hit_stream_make(&stages->hits, device, stages->tiles * TILE_PIXELS, log));

done:
  return status;
}

Status raster_stages_open(RasterStages *out, const char *path, const char *device, uint32_t threads)
{
  Status status = STATUS_OK;
  *out = (RasterStages){0};
  TRY(bench_scene_open(&out->base, path, (double)WIDTH / HEIGHT, device, threads));
  TRY(passes_make(out));
  raster_views_aim(&out->views, &out->base.scene, &out->camera.info, map_px[0], CUBE_PX);
  TRY(frame_prepare(out));

done:
  return status;
}

void raster_stages_close(RasterStages *stages)
{
  hit_stream_free(&stages->hits);
  camera_rays_free(&stages->camera);
  raster_visibility_free(&stages->visibility);
  raster_depth_free(&stages->cube);
  buffer_free(&stages->frame_maps);
  for (int i = 0; i < MAPS; i++) raster_depth_free(&stages->maps[i]);
  raster_scene_free(&stages->triangles);
  frame_free(&stages->frame);
  for (int i = 0; i < CAPTURES; i++) frame_free(&stages->captures[i]);
  device_scene_free(&stages->lit_scene);
  bench_scene_close(&stages->base);
}

void raster_kernels_print(const Timeline *timeline, size_t first, int rounds)
{
  for (size_t i = first; i < timeline->count; i++) {
    double sum_ms = 0;
    bool before = false;
    for (size_t k = first; k < timeline->count; k++) {
      bool same = !strcmp(timeline->spans[k].name, timeline->spans[i].name);
      before = before || (same && k < i);
      if (same) sum_ms += timeline->spans[k].end_ms - timeline->spans[k].begin_ms;
    }
    if (!before) printf("      %-44s %8.2f ms\n", timeline->spans[i].name, sum_ms / rounds);
  }
}

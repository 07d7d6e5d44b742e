// Raster speed beside Mesa's llvmpipe, on the same welded triangles, sizes and culling (none), clears included, A B A B
// in one run, two threads each. A benchmark, not a test. Ratios are theirs to ours, of times and of processor times:
// other work on the machine moves the second less.
//
// Usage: bench_raster [-v] SCENE.glb... ; stages: a depth map of 1024 and of 2048 texels a side, from a light that sees
// the whole scene; the six faces of a cube of 256, depth alone, by one view table here and face after face there; what
// the file's camera sees at 1080p, here the hit stream that shading reads (depth, id and two weights: 16 bytes a
// pixel), there id and depth (8 bytes); the same shaded by one light with 3 x 3 compares of its depth map of 2048, here
// all that a render does from the wave of camera rays to the sums of the picture, with glTF's BRDF and textures, there
// diffuse white in 8 bits; the whole frame: that depth map and the shaded camera. Before any timing both must show the
// same maps and triangles, or it stops. -v: times by kernel.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "bench/raster_views.h"
#include "bench/scene.h"
#include "passes/raster_depth.h"
#include "passes/raster_visibility.h"
#include "render/frame.h"
#include "shared/depth_map.h"
#include "shared/raster.h"
#include "shared/stream.h"

enum { WIDTH = 1920, HEIGHT = 1080, PIXELS = WIDTH * HEIGHT, ROUNDS = 7, THREADS = 2, MAPS = 2, CUBE_PX = 256 };
static const uint32_t map_px[MAPS] = {1024, 2048};

typedef enum Stage { MAP_1024, MAP_2048, CUBE, VISIBILITY, SHADED, FRAME, STAGES } Stage;
static const char *const stage_names[STAGES] = {"depth map 1024",   "depth map 2048",     "cube 6 x 256",
                                                "visibility 1080p", "shaded 1080p + PCF", "whole frame"};

typedef struct Bench {
  BenchScene base;
  GlPeer *peer;
  RasterScene triangles;
  RasterDepth maps[MAPS], cube;
  RasterVisibility visibility;
  CameraRays camera;
  HitStream hits;
  DeviceScene lit_scene;  // with the light of `views` alone
  Frame frame;            // of it
  RasterViews views;
  uint32_t tiles;
} Bench;

// What stages above 50 k triangles came to, of all scenes.
typedef struct Total {
  double log_sum, work_log_sum, least;
  uint32_t count;
} Total;

static Log *log_of(Bench *bench) { return &bench->base.log; }

static void stop(const char *cause)
{
  fprintf(stderr, "bench_raster: %s\n", cause);
  exit(1);
}

static Status depth_draw(Bench *bench, RasterDepth *raster, const RasterView *views, uint32_t count)
{
  return raster_depth(raster, bench->base.device, &bench->base.device_scene, &bench->triangles, views, count,
                      log_of(bench));
}

static Status map_draw(Bench *bench, int map)
{
  RasterView view = bench->views.light;
  for (Float4 *row = &view.x; row <= &view.y; row++) {  // rows are in texels
    float scale = (float)map_px[map] / (float)map_px[0];
    *row = (Float4){row->x * scale, row->y * scale, row->z * scale, row->w * scale};
  }
  view.width = view.height = map_px[map];
  return depth_draw(bench, &bench->maps[map], &view, 1);
}

static Status visibility_draw(Bench *bench)
{
  Status status = STATUS_OK;
  Wave wave = {0, bench->tiles, 0, 1};
  uint32_t capacity = bench->tiles * TILE_PIXELS;
  TRY(raster_visibility_aim(&bench->visibility, bench->base.device, &bench->camera, 1, capacity, log_of(bench)));
  TRY(raster_visibility(&bench->visibility, bench->base.device, &bench->base.device_scene, &bench->triangles,
                        &bench->camera, &wave, &bench->hits, capacity, log_of(bench)));

done:
  return status;
}

static double processor_ms(void)
{
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

static double ours_run_ms(Bench *bench, Stage stage)
{
  Status status = STATUS_OK;
  double begin_ms = clock_ms();
  if (stage == MAP_1024 || stage == MAP_2048) status = map_draw(bench, stage == MAP_2048);
  if (stage == CUBE) status = depth_draw(bench, &bench->cube, bench->views.faces, 6);
  if (stage == FRAME) status = map_draw(bench, 1);
  if (stage == VISIBILITY) status = visibility_draw(bench);
  if (!status && (stage == SHADED || stage == FRAME)) status = frame_render(&bench->frame, log_of(bench));
  if (!status) status = device_finish(bench->base.device, log_of(bench));
  if (status) stop(bench->base.log.error);
  return clock_ms() - begin_ms;
}

static double theirs_run_ms(Bench *bench, Stage stage)
{
  GlPeer *peer = bench->peer;
  double begin_ms = clock_ms();
  if (stage == MAP_1024) gl_peer_depth_map(peer, map_px[0], &bench->views.gl_light);
  if (stage == MAP_2048 || stage == FRAME) gl_peer_depth_map(peer, map_px[1], &bench->views.gl_light);
  if (stage == CUBE) gl_peer_cube(peer, CUBE_PX, bench->views.gl_faces);
  if (stage == VISIBILITY) gl_peer_ids(peer, WIDTH, HEIGHT, &bench->views.gl_camera);
  if (stage == SHADED || stage == FRAME)
    gl_peer_shaded(peer, WIDTH, HEIGHT, &bench->views.gl_camera, &bench->views.gl_light, bench->views.light_position);
  gl_peer_finish(peer);
  return clock_ms() - begin_ms;
}

// Share of texels whose depths are further apart than the steepest of planes rises in a snap of either side.
static double maps_differ(const float *theirs, const float *blocks, uint32_t size, uint32_t *covered)
{
  uint32_t differ = 0;
  for (uint32_t y = 0; y < size; y++) {
    for (uint32_t x = 0; x < size; x++) {
      float depth = blocks[depth_map_index(x, y, size)];
      differ += !(fabsf(theirs[y * size + x] - depth) < 1e-3f);
      *covered += depth < 1;
    }
  }
  return (double)differ / size / size;
}

// Column and row of a tile: cl/lib/tile.cl.
static void tile_place(uint32_t *x, uint32_t *y, uint32_t tile, const CameraInfo *camera)
{
  uint32_t rows = (camera->height + TILE_SIZE - 1) / TILE_SIZE, row_tiles = camera->tiles_per_row * BIN_TILES;
  uint32_t row = tile / row_tiles, left = rows - row * BIN_TILES, height = left < BIN_TILES ? left : BIN_TILES;
  uint32_t column = tile % row_tiles / (BIN_TILES * height), within = tile % row_tiles % (BIN_TILES * height);
  left = camera->tiles_per_row - column * BIN_TILES;
  uint32_t width = left < BIN_TILES ? left : BIN_TILES;
  *x = column * BIN_TILES + within % width;
  *y = row * BIN_TILES + within / width;
}

static double stage_differ(Bench *bench, Stage stage, float *ours, float *theirs, double *covered_share)
{
  static uint32_t ids[PIXELS], our_ids[PIXELS];
  uint32_t covered = 0, differ = 0, size = stage == CUBE ? CUBE_PX : map_px[stage == MAP_2048];
  Device *device = bench->base.device;
  double share = 0;
  if (stage == CUBE) {
    if (buffer_read(device, &bench->cube.maps, ours, sizeof *ours * 6 * size * size, log_of(bench))) stop("cube");
    for (int face = 0; face < 6; face++) {
      gl_peer_read_face(bench->peer, face, theirs);
      share += maps_differ(theirs, ours + (size_t)face * size * size, size, &covered) / 6;
    }
    *covered_share = (double)covered / size / size / 6;
    return share;
  }
  if (stage != VISIBILITY) {
    if (buffer_read(device, &bench->maps[stage == MAP_2048].maps, ours, sizeof *ours * size * size, log_of(bench)))
      stop("map");
    gl_peer_read_map(bench->peer, theirs);
    share = maps_differ(theirs, ours, size, &covered);
    *covered_share = (double)covered / size / size;
    return share;
  }
  gl_peer_read_ids(bench->peer, ids, theirs);
  if (buffer_read(device, &bench->hits.hits, ours, sizeof *ours * bench->tiles * TILE_PIXELS, log_of(bench)) ||
      buffer_read(device, &bench->hits.ids, our_ids, sizeof our_ids, log_of(bench)))
    stop("hits");
  for (uint32_t slot = 0; slot < PIXELS; slot++) {
    uint32_t within = slot % TILE_PIXELS, tile_x, tile_y;
    tile_place(&tile_x, &tile_y, slot / TILE_PIXELS, &bench->camera.info);
    uint32_t x = tile_x * TILE_SIZE + within / 16 % 2 * 4 + within % 4;
    uint32_t y = tile_y * TILE_SIZE + within / 32 * 4 + within % 16 / 4, pixel = y * WIDTH + x;
    double depth = our_ids[slot] == HIT_NONE ? 1 : 1 - bench->camera.info.near_m / (double)ours[slot];
    covered += our_ids[slot] != HIT_NONE;
    // The same triangle, or, where one is smaller than a snap tells apart, the same depth.
    differ += ids[pixel] != our_ids[slot] &&
              !(fabs((1 - (double)theirs[pixel]) / (1 - depth) - 1) < 1e-3 && our_ids[slot] != HIT_NONE);
  }
  *covered_share = (double)covered / PIXELS;
  return (double)differ / PIXELS;
}

// Stops unless both sides show the same but for edges that a snap of 1/256 of a pixel moves over a centre.
static void sameness_check(Bench *bench)
{
  float *ours = calloc((size_t)map_px[1] * map_px[1], sizeof *ours), *theirs = calloc(map_px[1] * map_px[1], 4);
  if (!ours || !theirs) stop("out of memory");
  printf("  both draw the same but for");
  for (Stage stage = 0; stage <= VISIBILITY; stage++) {
    double covered = 0;
    ours_run_ms(bench, stage);
    theirs_run_ms(bench, stage);
    double share = stage_differ(bench, stage, ours, theirs, &covered);
    printf("%s %.2f %%", stage ? "," : "", 100 * share);
    if (!(share < 0.01 && covered > 0.05)) {
      printf(" of %s: %.1f %% covered\n", stage_names[stage], 100 * covered);
      stop("the two sides do not draw the same");
    }
  }
  printf(" of texels\n");
  free(ours);
  free(theirs);
}

// Bytes that our passes read and write for each triangle of the scene: blocks, and the records of those that are seen.
// Not a number where a pass does not hold all.
static double triangle_bytes(Bench *bench, const RasterBins *bins, uint32_t pass_chunks, uint32_t views,
                             uint32_t record_words)
{
  size_t spans = (size_t)bench->triangles.chunk_count * views;
  if (!bins->spans.memory || pass_chunks < spans) return NAN;
  uint32_t *counts = calloc(spans, sizeof *counts);  // SPAN_COUNT comes first
  double records = 0;
  if (!counts || buffer_read(bench->base.device, &bins->spans, counts, spans * sizeof *counts, log_of(bench)))
    stop("the counts of triangles cannot be read");
  for (size_t i = 0; i < spans; i++) records += counts[i];
  free(counts);
  return 44.0 * views + 8.0 * record_words * records / bench->triangles.triangle_count;
}

static void bytes_print(Bench *bench, Stage stage)
{
  const RasterDepth *map = stage == CUBE ? &bench->cube : &bench->maps[stage == MAP_2048];
  double bytes = NAN;
  if (stage <= CUBE) bytes = triangle_bytes(bench, &map->binned, map->pass_chunks, stage == CUBE ? 6 : 1, DEPTH_WORDS);
  if (stage == VISIBILITY)
    bytes = triangle_bytes(bench, &bench->visibility.binned, bench->visibility.pass_chunks, 1, VISIBLE_WORDS);
  if (stage <= VISIBILITY) printf(" %8d", stage == VISIBILITY ? 16 : 4);
  if (bytes > 0) printf(" %11.0f", bytes);
}

// Mean time of each kernel since span `first`.
static void kernels_print(const Timeline *timeline, size_t first)
{
  for (size_t i = first; i < timeline->count; i++) {
    double sum_ms = 0;
    bool before = false;
    for (size_t k = first; k < timeline->count; k++) {
      bool same = !strcmp(timeline->spans[k].name, timeline->spans[i].name);
      before = before || (same && k < i);
      if (same) sum_ms += timeline->spans[k].end_ms - timeline->spans[k].begin_ms;
    }
    if (!before) printf("      %-44s %8.2f ms\n", timeline->spans[i].name, sum_ms / (ROUNDS + 1));
  }
}

typedef struct Times {
  double wall_ms[ROUNDS], processor_ms[ROUNDS];
} Times;

static void time_take(Times *times, int at, double (*run)(Bench *, Stage), Bench *bench, Stage stage)
{
  double begin_ms = processor_ms();
  times->wall_ms[at] = run(bench, stage);
  times->processor_ms[at] = processor_ms() - begin_ms;
}

static double median_ratio(const double *theirs, const double *ours)
{
  double ratios[ROUNDS];
  for (int i = 0; i < ROUNDS; i++) ratios[i] = theirs[i] / ours[i];
  return bench_median(ratios, ROUNDS);
}

static void stage_run(Bench *bench, Stage stage, bool verbose, Total *total)
{
  Times ours = {{0}, {0}}, theirs = {{0}, {0}};
  size_t first = bench->base.timeline.count;
  for (int round = -1; round < ROUNDS; round++) {  // round -1 warms up
    int at = round < 0 ? 0 : round;
    time_take(&ours, at, ours_run_ms, bench, stage);
    time_take(&theirs, at, theirs_run_ms, bench, stage);
  }
  double ratio = median_ratio(theirs.wall_ms, ours.wall_ms),
         work = median_ratio(theirs.processor_ms, ours.processor_ms);
  printf("  %-18s %8.2f %9.2f %7.2f %9.2f", stage_names[stage], bench_median(ours.wall_ms, ROUNDS),
         bench_median(theirs.wall_ms, ROUNDS), ratio, work);
  bytes_print(bench, stage);
  printf("\n");
  if (verbose) printf("      %-44s %8.2f ms\n", "processor time", bench_median(ours.processor_ms, ROUNDS));
  if (verbose) kernels_print(&bench->base.timeline, first);
  if (verbose && stage == VISIBILITY) {
    RasterCost cost;
    if (raster_visibility_cost(&cost, &bench->visibility, bench->base.device, log_of(bench))) stop("no costs");
    double frames = ROUNDS + 2;
    printf("      %.2f M tests of blocks, %.2f samples covered a pixel\n", 1e-6 * (double)cost.block_tests / frames,
           (double)cost.samples_covered / frames / PIXELS);
  }
  if (bench->triangles.triangle_count < 50000) return;
  total->least = total->count && total->least < ratio ? total->least : ratio;
  total->log_sum += log(ratio);
  total->work_log_sum += log(work);
  total->count++;
}

// A frame of the scene under one light, which stands where the peer's does and sees as much.
static Status frame_prepare(Bench *bench)
{
  Status status = STATUS_OK;
  Scene *scene = &bench->base.scene, kept = *scene;
  Vec3 low, high, at = vec3_from_floats(bench->views.light_position);
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
  SceneFacts facts = {.triangle_count = bench->triangles.triangle_count, .pixel_count = PIXELS, .light_count = 1};
  FrameRequest request = {.camera = &bench->base.camera,
                          .area = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT},
                          .samples = 1,
                          .plan = plan_make(&settings, &facts)};
  scene->lights = &light;
  scene->light_count = 1;
  TRY(device_scene_make(&bench->lit_scene, bench->base.device, scene, NULL, log_of(bench)));
  TRY(frame_make(&bench->frame, bench->base.device, &bench->lit_scene, &request, log_of(bench)));

done:
  *scene = kept;
  return status;
}

static Status passes_make(Bench *bench)
{
  Status status = STATUS_OK;
  const RasterOptions usual = {0};
  Device *device = bench->base.device;
  const DeviceScene *scene = &bench->base.device_scene;
  Log *log = log_of(bench);
  PictureArea area = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT};
  CameraInfo info = camera_info(&bench->base.camera, &area);
  if (info.orthographic) stop("the camera is orthographic");
  info.far_m = INFINITY;  // as in OpenGL's matrix above
  bench->tiles = info.tiles_per_row * (HEIGHT / TILE_SIZE);
  TRY(raster_scene_make(&bench->triangles, device, scene, &usual, log));
  for (int i = 0; i < MAPS; i++)
    TRY(raster_depth_make(&bench->maps[i], device, scene, &bench->triangles, map_px[i], 1, &usual, log));
  TRY(raster_depth_make(&bench->cube, device, scene, &bench->triangles, CUBE_PX, 6, &usual, log));
  TRY(raster_visibility_make(&bench->visibility, device, scene, &bench->triangles, &usual, log));
  TRY(camera_rays_make(&bench->camera, device, &info, 1, log));
  TRY(hit_stream_make(&bench->hits, device, bench->tiles * TILE_PIXELS, log));

done:
  return status;
}

static Status bench_run(Bench *bench, const char *path, bool verbose, Total *total)
{
  Status status = STATUS_OK;
  TRY(bench_scene_open(&bench->base, path, (double)WIDTH / HEIGHT, THREADS));
  TRY(passes_make(bench));
  bench->peer = gl_peer_open();
  if (!bench->peer) exit(1);
  raster_views_aim(&bench->views, &bench->base.scene, &bench->camera.info, map_px[0], CUBE_PX);
  uint32_t vertices = raster_peer_take(bench->peer, &bench->base.flat);
  printf("%s: %u triangles, %u vertices; %s, %u lanes; %s\n", path, bench->triangles.triangle_count, vertices,
         device_info(bench->base.device)->name, device_traits(bench->base.device)->lanes, gl_peer_name(bench->peer));
  TRY(frame_prepare(bench));
  sameness_check(bench);
  printf("  medians of %-2d       ours ms theirs ms   ratio processor  B/pixel  B/triangle\n", ROUNDS);
  for (Stage stage = 0; stage < STAGES; stage++) stage_run(bench, stage, verbose, total);

done:
  if (status) fprintf(stderr, "bench_raster: %s\n", bench->base.log.error);
  gl_peer_close(bench->peer);
  hit_stream_free(&bench->hits);
  camera_rays_free(&bench->camera);
  raster_visibility_free(&bench->visibility);
  raster_depth_free(&bench->cube);
  for (int i = 0; i < MAPS; i++) raster_depth_free(&bench->maps[i]);
  raster_scene_free(&bench->triangles);
  frame_free(&bench->frame);
  device_scene_free(&bench->lit_scene);
  bench_scene_close(&bench->base);
  return status;
}

int main(int argc, char **argv)
{
  Status worst = STATUS_OK;
  Total total = {0};
  bool verbose = argc > 1 && !strcmp(argv[1], "-v");
  char threads[16];
  snprintf(threads, sizeof threads, "%d", THREADS);
  setenv("LP_NUM_THREADS", threads, 1);
  for (int i = 1 + verbose; i < argc; i++) {
    Bench bench = {0};
    Status status = bench_run(&bench, argv[i], verbose, &total);
    if (status) worst = status;
  }
  if (total.count)
    printf(
        "%u stages above 50 k triangles: llvmpipe takes %.2f times as long in the geometric mean, %.2f at least, and "
        "%.2f times the processor time\n",
        total.count, exp(total.log_sum / total.count), total.least, exp(total.work_log_sum / total.count));
  return status_exit_code(worst);
}

// Raster speed beside Mesa's llvmpipe, on the same welded triangles, sizes and culling (none), clears included, A B A B
// in one run, two threads each. A benchmark, not a test. Ratios are theirs to ours, of times and of processor times:
// other work on the machine moves the second less.
//
// Usage: bench_raster [-v] SCENE.glb... ; stages: bench/raster_stages.h. There cube faces are drawn one after the
// other, visibility is id and depth (8 bytes a pixel; ours has two weights besides), and the shaded picture has glTF's
// BRDF and base colour textures like ours, in 16-bit floats where ours has 32, and a slope-scaled depth bias where ours
// follows the receiver's plane. Before any timing both must show the same maps, triangles and picture, or it stops; of
// the picture 60 % is enough, as our render fits its shadow map to the view. -v: times by kernel.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "bench/raster_peer.h"
#include "bench/raster_stages.h"
#include "shared/depth_map.h"
#include "shared/raster.h"
#include "shared/stream.h"

enum { ROUNDS = 7, THREADS = 2 };

typedef struct Bench {
  RasterStages ours;
  GlPeer *peer;
} Bench;

// What stages above 50 k triangles came to, of all scenes: of a frame, or of a capture.
typedef struct Total {
  double log_sum, work_log_sum, least;
  uint32_t count;
} Total;

static Log *log_of(Bench *bench) { return &bench->ours.base.log; }

static void stop(const char *cause)
{
  fprintf(stderr, "bench_raster: %s\n", cause);
  exit(1);
}

static double processor_ms(void)
{
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

static double ours_run_ms(Bench *bench, Stage stage)
{
  double begin_ms = clock_ms();
  if (raster_stage_run(&bench->ours, stage)) stop(log_of(bench)->error);
  return clock_ms() - begin_ms;
}

static GlSpot peer_light(const Bench *bench)
{
  const LightInfo *light = bench->ours.lit_scene.light_infos;
  return (GlSpot){{light->position.x, light->position.y, light->position.z},
                  {light->direction.x, light->direction.y, light->direction.z},
                  light->radiant.x,
                  light->spot_scale,
                  light->spot_offset};
}

static double theirs_run_ms(Bench *bench, Stage stage)
{
  GlPeer *peer = bench->peer;
  const RasterViews *views = &bench->ours.views;
  const Float3 at = bench->ours.camera.info.position;
  const float eye[3] = {at.x, at.y, at.z};
  const GlSpot light = peer_light(bench);
  double begin_ms = clock_ms();
  if (stage == MAP_1024) gl_peer_depth_map(peer, map_px[0], &views->gl_light, 0);
  if (stage == MAP_2048 || stage == FRAME) gl_peer_depth_map(peer, map_px[1], &views->gl_light, stage == FRAME ? 3 : 0);
  if (stage == CUBE) gl_peer_cube(peer, CUBE_PX, views->gl_faces);
  if (stage == VISIBILITY) gl_peer_ids(peer, WIDTH, HEIGHT, &views->gl_camera);
  if (stage == SHADED || stage == FRAME)
    gl_peer_shaded(peer, WIDTH, HEIGHT, &views->gl_camera, eye, &views->gl_light, &light);
  if (stage >= CAPTURE_256)
    gl_peer_captured(peer, capture_px[stage - CAPTURE_256], views->gl_faces, views->cube_center, &views->gl_light,
                     &light);
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
  Device *device = bench->ours.base.device;
  double share = 0;
  if (stage == CUBE) {
    if (buffer_read(device, &bench->ours.cube.maps, ours, sizeof *ours * 6 * size * size, log_of(bench))) stop("cube");
    for (int face = 0; face < 6; face++) {
      gl_peer_read_face(bench->peer, face, theirs);
      share += maps_differ(theirs, ours + (size_t)face * size * size, size, &covered) / 6;
    }
    *covered_share = (double)covered / size / size / 6;
    return share;
  }
  if (stage != VISIBILITY) {
    if (buffer_read(device, &bench->ours.maps[stage == MAP_2048].maps, ours, sizeof *ours * size * size, log_of(bench)))
      stop("map");
    gl_peer_read_map(bench->peer, theirs);
    share = maps_differ(theirs, ours, size, &covered);
    *covered_share = (double)covered / size / size;
    return share;
  }
  gl_peer_read_ids(bench->peer, ids, theirs);
  if (buffer_read(device, &bench->ours.hits.hits, ours, sizeof *ours * bench->ours.tiles * TILE_PIXELS,
                  log_of(bench)) ||
      buffer_read(device, &bench->ours.hits.ids, our_ids, sizeof our_ids, log_of(bench)))
    stop("hits");
  for (uint32_t slot = 0; slot < PIXELS; slot++) {
    uint32_t within = slot % TILE_PIXELS, tile_x, tile_y;
    tile_place(&tile_x, &tile_y, slot / TILE_PIXELS, &bench->ours.camera.info);
    uint32_t x = tile_x * TILE_SIZE + within / 16 % 2 * 4 + within % 4;
    uint32_t y = tile_y * TILE_SIZE + within / 32 * 4 + within % 16 / 4, pixel = y * WIDTH + x;
    double depth = our_ids[slot] == HIT_NONE ? 1 : 1 - bench->ours.camera.info.near_m / (double)ours[slot];
    covered += our_ids[slot] != HIT_NONE;
    // The same triangle, or, where one is smaller than a snap tells apart, the same depth.
    differ += ids[pixel] != our_ids[slot] &&
              !(fabs((1 - (double)theirs[pixel]) / (1 - depth) - 1) < 1e-3 && our_ids[slot] != HIT_NONE);
  }
  *covered_share = (double)covered / PIXELS;
  return (double)differ / PIXELS;
}

// Share of the pixels that show something whose displayed colours (sRGB's slope near black left out: the square root of
// radiance) differ by more than 2 / 255, or are not seen by both.
static double pictures_differ(Bench *bench)
{
  static float ours[PIXELS][4], theirs[PIXELS][4];
  uint32_t differ = 0, covered = 0;
  ours_run_ms(bench, FRAME);
  theirs_run_ms(bench, FRAME);
  Frame *frame = &bench->ours.frame;
  if (buffer_zero(bench->ours.base.device, &frame->film.sums, log_of(bench))) stop("picture");
  ours_run_ms(bench, SHADED);
  if (buffer_read(bench->ours.base.device, &frame->film.sums, ours, sizeof ours, log_of(bench))) stop("picture");
  gl_peer_read_shaded(bench->peer, theirs);
  for (uint32_t i = 0; i < PIXELS; i++) {
    bool seen = ours[i][3] > 0 || theirs[i][3] > 0, differs = (ours[i][3] > 0) != (theirs[i][3] > 0);
    for (int c = 0; c < 3; c++) {
      float a = sqrtf(fminf(fmaxf(ours[i][c], 0), 1)), b = sqrtf(fminf(fmaxf(theirs[i][c], 0), 1));
      differs |= !(fabsf(a - b) <= 2.0f / 255);
    }
    covered += seen;
    differ += seen && differs;
  }
  if (covered < PIXELS / 20) stop("the picture is nearly empty");
  return (double)differ / covered;
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
  double share = pictures_differ(bench);
  printf(" of texels, and for %.2f %% of the pixels of the shaded picture\n", 100 * share);
  if (!(share < 0.4)) stop("the two sides do not shade the same");
  free(ours);
  free(theirs);
}

// Bytes that our passes read and write for each triangle of the scene: blocks, and the records of those that are seen.
// Not a number where a pass does not hold all.
static double triangle_bytes(Bench *bench, const RasterBins *bins, const RasterItems *items, uint32_t view_count,
                             uint32_t record_words)
{
  Device *device = bench->ours.base.device;
  if (!bins->spans.memory || items->pass < items->count) return NAN;
  uint32_t *counts = calloc(items->count, sizeof *counts), seen = 0;  // SPAN_COUNT comes first
  double records = 0;
  if (!counts || buffer_read(device, &bins->spans, counts, items->count * sizeof *counts, log_of(bench)) ||
      buffer_read_part(device, &items->starts, view_count * sizeof seen, &seen, sizeof seen, log_of(bench)))
    stop("the counts of triangles cannot be read");
  for (size_t i = 0; i < seen; i++) records += counts[i];
  free(counts);
  return (44.0 * RASTER_CHUNK * seen + 8.0 * record_words * records) / bench->ours.triangles.triangle_count;
}

static void bytes_print(Bench *bench, Stage stage)
{
  const RasterVisibility *eye = &bench->ours.visibility;
  const RasterDepth *map = stage == CUBE ? &bench->ours.cube : &bench->ours.maps[stage == MAP_2048];
  double bytes = NAN;
  if (stage <= CUBE) bytes = triangle_bytes(bench, &map->binned, &map->items, stage == CUBE ? 6 : 1, DEPTH_WORDS);
  if (stage == VISIBILITY) bytes = triangle_bytes(bench, &eye->binned, &eye->items, 1, VISIBLE_WORDS);
  if (stage <= VISIBILITY) printf(" %8d", stage == VISIBILITY ? 16 : 4);
  if (bytes > 0) printf(" %11.0f", bytes);
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

// Visibility counts with its shading, not alone.
enum { OF_FRAMES, OF_CAPTURES, TOTALS };

static void total_add(Total *total, double ratio, double work)
{
  total->least = total->count && total->least < ratio ? total->least : ratio;
  total->log_sum += log(ratio);
  total->work_log_sum += log(work);
  total->count++;
}

static void stage_run(Bench *bench, Stage stage, bool verbose, Total totals[TOTALS])
{
  Times ours = {{0}, {0}}, theirs = {{0}, {0}};
  size_t first = bench->ours.base.timeline.count;
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
  if (verbose) raster_kernels_print(&bench->ours.base.timeline, first, ROUNDS + 1);
  if (verbose && stage == VISIBILITY) {
    RasterCost cost;
    if (raster_visibility_cost(&cost, &bench->ours.visibility, bench->ours.base.device, log_of(bench)))
      stop("no costs");
    double frames = ROUNDS + 2;
    printf("      %.2f M tests of blocks, %.2f samples covered a pixel\n", 1e-6 * (double)cost.block_tests / frames,
           (double)cost.samples_covered / frames / PIXELS);
  }
  if (bench->ours.triangles.triangle_count < 50000 || stage == VISIBILITY) return;
  total_add(&totals[stage >= CAPTURE_256 ? OF_CAPTURES : OF_FRAMES], ratio, work);
}

static Status bench_run(Bench *bench, const char *path, bool verbose, Total totals[TOTALS])
{
  Status status = STATUS_OK;
  const RasterStages *ours = &bench->ours;
  TRY(raster_stages_open(&bench->ours, path, NULL, THREADS));
  bench->peer = gl_peer_open();
  if (!bench->peer) exit(1);
  uint32_t vertices = raster_peer_take(bench->peer, &ours->base.flat);
  printf("%s: %u triangles, %u vertices; %s, %u lanes; %s\n", path, ours->triangles.triangle_count, vertices,
         device_info(ours->base.device)->name, device_traits(ours->base.device)->lanes, gl_peer_name(bench->peer));
  sameness_check(bench);
  printf("  medians of %-2d       ours ms theirs ms   ratio processor  B/pixel  B/triangle\n", ROUNDS);
  for (Stage stage = 0; stage < PEER_STAGES; stage++) stage_run(bench, stage, verbose, totals);

done:
  if (status) fprintf(stderr, "bench_raster: %s\n", log_of(bench)->error);
  gl_peer_close(bench->peer);
  raster_stages_close(&bench->ours);
  return status;
}

int main(int argc, char **argv)
{
  Status worst = STATUS_OK;
  Total totals[TOTALS] = {{0}};
  bool verbose = argc > 1 && !strcmp(argv[1], "-v");
  char threads[16];
  snprintf(threads, sizeof threads, "%d", THREADS);
  setenv("LP_NUM_THREADS", threads, 1);
  for (int i = 1 + verbose; i < argc; i++) {
    Bench bench = {0};
    Status status = bench_run(&bench, argv[i], verbose, totals);
    if (status) worst = status;
  }
  const char *const names[TOTALS] = {"stages of frames", "captures"};
  for (int i = 0; i < TOTALS; i++) {
    if (!totals[i].count) continue;
    printf(
        "%u %s above 50 k triangles: llvmpipe takes %.2f times as long in the geometric mean, %.2f at least, and "
        "%.2f times the processor time\n",
        totals[i].count, names[i], exp(totals[i].log_sum / totals[i].count), totals[i].least,
        exp(totals[i].work_log_sum / totals[i].count));
  }
  return status_exit_code(worst);
}

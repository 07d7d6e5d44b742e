// Ray speed beside Embree, on the same triangles and the same rays, A B A B in one run. A benchmark, not a test.
//
// Usage: bench_rays SCENE.glb... ; classes of rays: primary (the file's camera), shadow (to the first light), mirror
// (reflected at every first hit), diffuse (cosine-distributed at every first hit). Embree's figure is the best of its
// single-ray, packet-8 and packet-16 modes.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#define EMBREE_4 1
#else
#include <embree3/rtcore.h>
#endif

#include "base/clock.h"
#include "base/parallel.h"
#include "bench/scene.h"
#include "passes/camera_rays.h"
#include "passes/trace.h"
#include "shared/stream.h"

enum { WIDTH = 1024, HEIGHT = 768, RAYS = WIDTH * HEIGHT, CHUNK = 4096, ROUNDS = 7 };

typedef enum RayClass { PRIMARY, SHADOW, MIRROR, DIFFUSE, CLASS_COUNT } RayClass;
static const char *const class_names[] = {"primary", "shadow", "mirror", "diffuse"};

typedef struct Bench {
  BenchScene base;
  Tracer tracer;
  RayStream stream;
  HitStream hits;
  DeviceBuffer radiance;
  RTCDevice embree;
  RTCScene embree_scene;
  float *rays[CLASS_COUNT];  // [RAY_FIELD_COUNT][RAYS]
  uint32_t *ids;             // of the primary hits, by Embree
  float *distances;
  double bvh_ms, embree_build_ms;
} Bench;

static float ray_field(const float *rays, int field, size_t i) { return rays[(size_t)field * RAYS + i]; }

typedef struct EmbreeJob {
  const Bench *bench;
  const float *rays;
  bool any_hit, coherent;
  int width;  // 1, 8 or 16
  uint32_t *ids;
  float *distances;
} EmbreeJob;

#define TRACE_PACKET(N)                                                                                        \
  static void embree_trace_##N(const EmbreeJob *job, size_t first)                                             \
  {                                                                                                            \
    struct RTCRayHit##N packet;                                                                                \
    int valid[N];                                                                                              \
    for (int i = 0; i < N; i++) {                                                                              \
      const float *r = job->rays;                                                                              \
      size_t at = first + (size_t)i;                                                                           \
      valid[i] = ray_field(r, RAY_T_MAX, at) > 0 ? -1 : 0;                                                     \
      packet.ray.org_x[i] = ray_field(r, RAY_ORIGIN_X, at);                                                    \
      packet.ray.org_y[i] = ray_field(r, RAY_ORIGIN_Y, at);                                                    \
      packet.ray.org_z[i] = ray_field(r, RAY_ORIGIN_Z, at);                                                    \
      packet.ray.dir_x[i] = ray_field(r, RAY_DIRECTION_X, at);                                                 \
      packet.ray.dir_y[i] = ray_field(r, RAY_DIRECTION_Y, at);                                                 \
      packet.ray.dir_z[i] = ray_field(r, RAY_DIRECTION_Z, at);                                                 \
      packet.ray.tnear[i] = 0;                                                                                 \
      packet.ray.tfar[i] = ray_field(r, RAY_T_MAX, at);                                                        \
      packet.ray.time[i] = 0;                                                                                  \
      packet.ray.mask[i] = ~0u;                                                                                \
      packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;                                \
    }                                                                                                          \
    EMBREE_CALL(N, valid, packet);                                                                             \
    for (int i = 0; i < N; i++) {                                                                              \
      if (job->ids) job->ids[first + (size_t)i] = packet.hit.geomID[i] == 0 ? packet.hit.primID[i] : HIT_NONE; \
      if (job->distances) job->distances[first + (size_t)i] = packet.ray.tfar[i];                              \
    }                                                                                                          \
  }

#ifdef EMBREE_4
#define EMBREE_CALL(N, valid, packet)                                                \
  struct RTCIntersectArguments intersect;                                            \
  struct RTCOccludedArguments occluded;                                              \
  rtcInitIntersectArguments(&intersect);                                             \
  rtcInitOccludedArguments(&occluded);                                               \
  if (job->coherent) intersect.flags = occluded.flags = RTC_RAY_QUERY_FLAG_COHERENT; \
  if (job->any_hit)                                                                  \
    rtcOccluded##N(valid, job->bench->embree_scene, &packet.ray, &occluded);         \
  else                                                                               \
    rtcIntersect##N(valid, job->bench->embree_scene, &packet, &intersect)
#else
#define EMBREE_CALL(N, valid, packet)                                       \
  struct RTCIntersectContext context;                                       \
  rtcInitIntersectContext(&context);                                        \
  if (job->coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;   \
  if (job->any_hit)                                                         \
    rtcOccluded##N(valid, job->bench->embree_scene, &context, &packet.ray); \
  else                                                                      \
    rtcIntersect##N(valid, job->bench->embree_scene, &context, &packet)
#endif
TRACE_PACKET(8)
TRACE_PACKET(16)

static void embree_trace_1(const EmbreeJob *job, size_t i)
{
  const float *r = job->rays;
  if (ray_field(r, RAY_T_MAX, i) <= 0) return;
  struct RTCRayHit one = {.ray = {.org_x = ray_field(r, RAY_ORIGIN_X, i),
                                  .org_y = ray_field(r, RAY_ORIGIN_Y, i),
                                  .org_z = ray_field(r, RAY_ORIGIN_Z, i),
                                  .dir_x = ray_field(r, RAY_DIRECTION_X, i),
                                  .dir_y = ray_field(r, RAY_DIRECTION_Y, i),
                                  .dir_z = ray_field(r, RAY_DIRECTION_Z, i),
                                  .tfar = ray_field(r, RAY_T_MAX, i),
                                  .mask = ~0u},
                          .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
#ifdef EMBREE_4
  if (job->any_hit)
    rtcOccluded1(job->bench->embree_scene, &one.ray, NULL);
  else
    rtcIntersect1(job->bench->embree_scene, &one, NULL);
#else
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (job->any_hit)
    rtcOccluded1(job->bench->embree_scene, &context, &one.ray);
  else
    rtcIntersect1(job->bench->embree_scene, &context, &one);
#endif
}

static void embree_chunk(void *context, size_t chunk)
{
  const EmbreeJob *job = context;
  for (size_t i = chunk * CHUNK; i < (chunk + 1) * CHUNK; i += (size_t)job->width) {
    if (job->width == 1) embree_trace_1(job, i);
    if (job->width == 8) embree_trace_8(job, i);
    if (job->width == 16) embree_trace_16(job, i);
  }
}

static double embree_run_ms(const EmbreeJob *job)
{
  double begin_ms = clock_ms();
  parallel_for(RAYS / CHUNK, embree_chunk, (void *)job);
  return clock_ms() - begin_ms;
}

static double ours_run_ms(Bench *bench, RayClass class, Coherence coherence)
{
  size_t before = bench->base.timeline.count;
  Status status = class == SHADOW
                      ? trace_any(&bench->tracer, bench->base.device, &bench->base.device_scene, &bench->stream, 0,
                                  RAYS, &bench->radiance, coherence, "trace", &bench->base.log)
                      : trace_closest(&bench->tracer, bench->base.device, &bench->base.device_scene, &bench->stream,
                                      RAYS, 0, &bench->hits, coherence, "trace", &bench->base.log);
  if (!status) status = device_finish(bench->base.device, &bench->base.log);
  if (status || bench->base.timeline.count == before) {
    fprintf(stderr, "bench_rays: %s\n", bench->base.log.error);
    exit(1);
  }
  const Span *span = &bench->base.timeline.spans[bench->base.timeline.count - 1];
  return span->end_ms - span->begin_ms;
}

static void class_run(Bench *bench, RayClass class)
{
  static uint32_t slots[RAYS];
  for (uint32_t i = 0; i < RAYS; i++) slots[i] = i;
  buffer_write(bench->base.device, &bench->stream.rays, bench->rays[class], sizeof(float) * RAY_FIELD_COUNT * RAYS,
               &bench->base.log);
  buffer_write(bench->base.device, &bench->stream.slots, slots, sizeof slots, &bench->base.log);
  static const int widths[] = {1, 8, 16};
  double theirs[3][ROUNDS], ours[2][ROUNDS];
  bool wide = bench->tracer.single_program != NULL;
  for (int round = -1; round < ROUNDS; round++) {  // round -1 warms up
    int at = round < 0 ? 0 : round;
    for (int c = 0; c < 1 + wide; c++) ours[c][at] = ours_run_ms(bench, class, c ? RAYS_INCOHERENT : RAYS_COHERENT);
    for (int w = 0; w < 3; w++) {
      EmbreeJob job = {.bench = bench,
                       .rays = bench->rays[class],
                       .any_hit = class == SHADOW,
                       .coherent = class != DIFFUSE,
                       .width = widths[w]};
      theirs[w][at] = embree_run_ms(&job);
    }
  }
  uint32_t active = 0;
  for (size_t i = 0; i < RAYS; i++) active += ray_field(bench->rays[class], RAY_T_MAX, i) > 0;
  double best = INFINITY, packet = bench_median(ours[0], ROUNDS),
         single = wide ? bench_median(ours[1], ROUNDS) : INFINITY;
  int best_width = 0;
  for (int w = 0; w < 3; w++) {
    double ms = bench_median(theirs[w], ROUNDS);
    if (ms < best) best = ms, best_width = widths[w];
  }
  double chosen = fmin(packet, single);
  printf("  %-8s %8u  packet %7.1f  single %7.1f  embree %7.1f (width %2d)  ours/embree %.2f\n", class_names[class],
         active, 1e-3 * active / packet, 1e-3 * active / single, 1e-3 * active / best, best_width, best / chosen);
}

static Vec3 position_of(const Bench *bench, uint32_t id, int corner)
{
  return vec3_from_floats(bench->base.flat.positions[bench->base.flat.corners[id].vertex[corner]]);
}

static void ray_set(float *rays, size_t i, Vec3 origin, Vec3 direction, double t_max)
{
  const double fields[] = {origin.x, origin.y, origin.z, direction.x, direction.y, direction.z, t_max, 0, 0, 0, 0};
  for (size_t f = 0; f < RAY_FIELD_COUNT; f++) rays[f * RAYS + i] = (float)fields[f];
}

static uint32_t hash(uint32_t x)
{
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

// Shadow, mirror and diffuse rays of the first hits.
static void secondary_rays_make(Bench *bench)
{
  const float *primary = bench->rays[PRIMARY];
  Vec3 low = {0}, high = {0};
  scene_bounds(&bench->base.scene, &low, &high);
  Vec3 light = bench->base.scene.light_count && bench->base.scene.lights[0].kind != LIGHT_DIRECTIONAL
                   ? bench->base.scene.lights[0].position_world
                   : vec3(0.3 * low.x + 0.7 * high.x, high.y + 0.5 * (high.y - low.y), 0.4 * low.z + 0.6 * high.z);
  for (size_t i = 0; i < RAYS; i++) {
    for (int c = SHADOW; c < CLASS_COUNT; c++) ray_set(bench->rays[c], i, vec3(0, 0, 0), vec3(0, 0, 1), -1);
    uint32_t id = bench->ids[i];
    if (id == HIT_NONE) continue;
    Vec3 direction = vec3(ray_field(primary, RAY_DIRECTION_X, i), ray_field(primary, RAY_DIRECTION_Y, i),
                          ray_field(primary, RAY_DIRECTION_Z, i));
    Vec3 origin = vec3(ray_field(primary, RAY_ORIGIN_X, i), ray_field(primary, RAY_ORIGIN_Y, i),
                       ray_field(primary, RAY_ORIGIN_Z, i));
    Vec3 edge1 = vec3_sub(position_of(bench, id, 1), position_of(bench, id, 0));
    Vec3 edge2 = vec3_sub(position_of(bench, id, 2), position_of(bench, id, 0));
    Vec3 n = vec3_unit_or(vec3_cross(edge1, edge2), vec3(0, 1, 0));
    if (vec3_dot(n, direction) > 0) n = vec3_neg(n);
    Vec3 p = vec3_add(vec3_add(origin, vec3_scale(direction, bench->distances[i])),
                      vec3_scale(n, 1e-4 * vec3_length(vec3_sub(high, low))));
    Vec3 d = vec3_unit_or(direction, vec3(0, 0, 1));
    ray_set(bench->rays[SHADOW], i, p, vec3_sub(light, p), 1);
    ray_set(bench->rays[MIRROR], i, p, vec3_sub(d, vec3_scale(n, 2 * vec3_dot(d, n))), INFINITY);
    double u = hash((uint32_t)i * 2 + 1) / 4294967296.0, phi = 2 * M_PI * (hash((uint32_t)i * 2 + 2) / 4294967296.0);
    Vec3 s = vec3_unit_or(vec3_cross(n, fabs(n.x) < 0.7 ? vec3(1, 0, 0) : vec3(0, 1, 0)), n), t = vec3_cross(n, s);
    Vec3 out = vec3_add(vec3_scale(n, sqrt(1 - u)),
                        vec3_add(vec3_scale(s, sqrt(u) * cos(phi)), vec3_scale(t, sqrt(u) * sin(phi))));
    ray_set(bench->rays[DIFFUSE], i, p, out, INFINITY);
  }
}

static void embree_make(Bench *bench)
{
  const FlatScene *flat = &bench->base.flat;
  char config[32];
  snprintf(config, sizeof config, "threads=%u", parallel_threads());
  bench->embree = rtcNewDevice(config);
  bench->embree_scene = rtcNewScene(bench->embree);
  RTCGeometry geometry = rtcNewGeometry(bench->embree, RTC_GEOMETRY_TYPE_TRIANGLE);
  float *positions =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, flat->vertex_count);
  uint32_t *indices =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, flat->triangle_count);
  memcpy(positions, flat->positions, 12 * (size_t)flat->vertex_count);
  for (size_t i = 0; i < flat->triangle_count; i++) memcpy(indices + 3 * i, flat->corners[i].vertex, 12);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(bench->embree_scene, geometry);
  rtcReleaseGeometry(geometry);
  double begin_ms = clock_ms();
  rtcCommitScene(bench->embree_scene);
  bench->embree_build_ms = clock_ms() - begin_ms;
}

static Status bench_run(Bench *bench, const char *path)
{
  Status status = STATUS_OK;
  TRY(bench_scene_open(&bench->base, path, (double)WIDTH / HEIGHT, NULL, 0));
  for (size_t i = 0; i < bench->base.timeline.count; i++)
    if (!strcmp(bench->base.timeline.spans[i].name, "build the BVH"))
      bench->bvh_ms = bench->base.timeline.spans[i].end_ms - bench->base.timeline.spans[i].begin_ms;
  TRY(tracer_make(&bench->tracer, bench->base.device, &bench->base.device_scene, &bench->base.log));
  TRY(ray_stream_make(&bench->stream, bench->base.device, RAYS, 1, "rays", &bench->base.log));
  TRY(hit_stream_make(&bench->hits, bench->base.device, RAYS, &bench->base.log));
  TRY(buffer_create(&bench->radiance, bench->base.device, RAYS * 16, NULL, "radiance", &bench->base.log));
  for (int c = 0; c < CLASS_COUNT; c++) bench->rays[c] = calloc((size_t)RAYS * RAY_FIELD_COUNT, sizeof(float));
  bench->ids = calloc(RAYS, sizeof *bench->ids);
  bench->distances = calloc(RAYS, sizeof *bench->distances);

  PictureArea area = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT};
  CameraInfo info = camera_info(&bench->base.camera, &area);
  CameraRays camera = {0};
  TRY(camera_rays_make(&camera, bench->base.device, &info, 1, &bench->base.log));
  Wave wave = {0, RAYS / 64, 0, 1};
  TRY(camera_rays_generate(&camera, bench->base.device, &wave, &bench->stream, &bench->base.log));
  TRY(buffer_read(bench->base.device, &bench->stream.rays, bench->rays[PRIMARY], sizeof(float) * RAY_FIELD_COUNT * RAYS,
                  &bench->base.log));
  camera_rays_free(&camera);

  embree_make(bench);
  EmbreeJob job = {
      .bench = bench, .rays = bench->rays[PRIMARY], .width = 8, .ids = bench->ids, .distances = bench->distances};
  embree_run_ms(&job);
  secondary_rays_make(bench);
  printf("%s: %u triangles, %s, %u lanes; build %.1f ms (Embree %.1f); Mrays/s, medians of %d\n", path,
         bench->base.flat.triangle_count, device_info(bench->base.device)->name,
         device_traits(bench->base.device)->lanes, bench->bvh_ms, bench->embree_build_ms, ROUNDS);
  for (int c = 0; c < CLASS_COUNT; c++) class_run(bench, (RayClass)c);

done:
  if (status) fprintf(stderr, "bench_rays: %s\n", bench->base.log.error);
  for (int c = 0; c < CLASS_COUNT; c++) free(bench->rays[c]);
  free(bench->ids);
  free(bench->distances);
  if (bench->embree_scene) rtcReleaseScene(bench->embree_scene);
  if (bench->embree) rtcReleaseDevice(bench->embree);
  buffer_free(&bench->radiance);
  ray_stream_free(&bench->stream);
  hit_stream_free(&bench->hits);
  tracer_free(&bench->tracer);
  bench_scene_close(&bench->base);
  return status;
}

int main(int argc, char **argv)
{
  Status worst = STATUS_OK;
  for (int i = 1; i < argc; i++) {
    Bench bench = {0};
    Status status = bench_run(&bench, argv[i]);
    if (status) worst = status;
  }
  return status_exit_code(worst);
}

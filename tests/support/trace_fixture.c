#include "support/trace_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "shared/stream.h"
#include "support/oracle_surface.h"
#include "support/test_device.h"

const char *const trace_kernel_names[TRACE_KERNELS] = {"packets of 16", "packets of 8", "packets of 1", "single rays"};

static const DeviceTraits traits_of_width[TRACE_WIDTHS] = {
    {.lanes = 16, .rays_per_item = 64, .group_size = 1, .wave_rays = TRACE_CAPACITY, .wide_bvh = true},
    {.lanes = 8, .rays_per_item = 64, .group_size = 1, .wave_rays = TRACE_CAPACITY, .wide_bvh = false},
    {.lanes = 1, .rays_per_item = 1, .group_size = 64, .wave_rays = TRACE_CAPACITY, .wide_bvh = false},
};

static void assert_ok(Status status, const Log *log)
{
  if (status) fail_msg("status %d: %s", status, log->error);
}

// Makes the device one of that width until the next call, and returns its tracer.
static Tracer *tracer_choose(TraceFixture *fixture, TraceKernel kernel)
{
  int width = test_on_gpu() ? TRACE_PACKET_1 : kernel == TRACE_SINGLE ? TRACE_PACKET_16 : (int)kernel;
  device_override_traits(fixture->device, &traits_of_width[width]);
  return &fixture->tracers[width];
}

void trace_fixture_make(TraceFixture *out, const Soup *soup)
{
  Log log = {0};
  *out = (TraceFixture){.model = scene_from_soup(soup)};
  out->oracle = oracle_scene_from_model(&out->model);
  out->oracle.coverage = oracle_surface_coverage;
  assert_ok(device_open(&out->device, test_device(), 0, NULL, &log), &log);
  tracer_choose(out, TRACE_PACKET_16);
  assert_ok(device_scene_make(&out->scene, out->device, &out->model, NULL, &log), &log);
  for (int width = 0; width < TRACE_WIDTHS; width++) {
    Tracer *tracer = tracer_choose(out, (TraceKernel)width);
    assert_ok(tracer_make(tracer, out->device, &out->scene, &log), &log);
  }
  assert_ok(ray_stream_make(&out->stream, out->device, TRACE_CAPACITY, 2, "rays", &log), &log);
  assert_ok(hit_stream_make(&out->hits, out->device, TRACE_CAPACITY, &log), &log);
  size_t bytes = TRACE_CAPACITY * sizeof(Float4);
  assert_ok(buffer_create(&out->radiance, out->device, bytes, NULL, "radiance", &log), &log);
}

void trace_fixture_free(TraceFixture *fixture)
{
  for (int width = 0; width < TRACE_WIDTHS; width++) tracer_free(&fixture->tracers[width]);
  ray_stream_free(&fixture->stream);
  hit_stream_free(&fixture->hits);
  buffer_free(&fixture->radiance);
  device_scene_free(&fixture->scene);
  device_close(fixture->device);
  oracle_scene_free(&fixture->oracle);
  scene_free(&fixture->model);
}

// What an any-hit ray adds: tells rays and channels apart.
static Float4 weight_of(uint32_t ray) { return (Float4){(float)(ray + 1), (float)(ray % 7 + 1), 0.5f, 0}; }

// A slot that is not the ray's own number.
static uint32_t slot_of(uint32_t ray) { return TRACE_CAPACITY - 1 - ray; }

// Writes rays into a segment; the other and the places behind the last ray hold rays that hit whatever they can, and
// slots of others.
static void rays_write(TraceFixture *fixture, const TraceRay *rays, uint32_t count, uint32_t segment)
{
  Log log = {0};
  const size_t all = (size_t)2 * TRACE_CAPACITY;
  float *fields = oracle_array(all * RAY_FIELD_COUNT, sizeof *fields);
  uint32_t *slots = oracle_array(all, sizeof *slots);
  for (uint32_t s = 0; s < 2; s++) {
    float *to = fields + (size_t)s * TRACE_CAPACITY * RAY_FIELD_COUNT;
    for (uint32_t i = 0; i < TRACE_CAPACITY; i++) {
      const TraceRay *ray = &rays[i < count ? i : i % count];
      Float4 weight = weight_of(i);
      float values[RAY_FIELD_COUNT] = {ray->origin[0],    ray->origin[1],    ray->origin[2], ray->direction[0],
                                       ray->direction[1], ray->direction[2], INFINITY,       weight.x,
                                       weight.y,          weight.z};
      if (s == segment && i < count) values[RAY_T_MAX] = ray->t_max;
      for (int field = 0; field < RAY_FIELD_COUNT; field++) to[(size_t)field * TRACE_CAPACITY + i] = values[field];
      slots[s * TRACE_CAPACITY + i] = s == segment ? slot_of(i) : i;
    }
  }
  DeviceBuffer ray_buffer = fixture->stream.rays, slot_buffer = fixture->stream.slots;
  assert_ok(buffer_write(fixture->device, &ray_buffer, fields, all * RAY_FIELD_COUNT * sizeof *fields, &log), &log);
  assert_ok(buffer_write(fixture->device, &slot_buffer, slots, all * sizeof *slots, &log), &log);
  free(fields);
  free(slots);
}

static Coherence coherence_of(TraceKernel kernel) { return kernel == TRACE_SINGLE ? RAYS_INCOHERENT : RAYS_COHERENT; }

static void closest_launch(TraceHit *out, TraceFixture *fixture, TraceKernel kernel, const TraceRay *rays,
                           uint32_t count, float t_min)
{
  Log log = {0};
  Tracer *tracer = tracer_choose(fixture, kernel);
  float *fields = oracle_array(TRACE_CAPACITY * HIT_FIELD_COUNT, sizeof *fields);
  uint32_t *ids = oracle_array(TRACE_CAPACITY, sizeof *ids);
  rays_write(fixture, rays, count, 0);
  assert_ok(trace_closest(tracer, fixture->device, &fixture->scene, &fixture->stream, count, t_min, &fixture->hits,
                          coherence_of(kernel), "trace", &log),
            &log);
  size_t bytes = TRACE_CAPACITY * sizeof(float);
  assert_ok(buffer_read(fixture->device, &fixture->hits.hits, fields, bytes * HIT_FIELD_COUNT, &log), &log);
  assert_ok(buffer_read(fixture->device, &fixture->hits.ids, ids, count * sizeof *ids, &log), &log);
  for (uint32_t i = 0; i < count; i++) {
    out[i] = (TraceHit){.triangle = ids[i]};
    if (ids[i] == HIT_NONE) continue;
    out[i].t = fields[HIT_T * TRACE_CAPACITY + i];
    out[i].u = fields[HIT_U * TRACE_CAPACITY + i];
    out[i].v = fields[HIT_V * TRACE_CAPACITY + i];
  }
  free(fields);
  free(ids);
}

static void lit_launch(bool *out, TraceFixture *fixture, TraceKernel kernel, const TraceRay *rays, uint32_t count)
{
  Log log = {0};
  Tracer *tracer = tracer_choose(fixture, kernel);
  Float4 *radiance = oracle_array(TRACE_CAPACITY, sizeof *radiance);
  rays_write(fixture, rays, count, 1);
  assert_ok(buffer_zero(fixture->device, &fixture->radiance, &log), &log);
  assert_ok(trace_any(tracer, fixture->device, &fixture->scene, &fixture->stream, 1, count, &fixture->radiance,
                      coherence_of(kernel), "trace", &log),
            &log);
  size_t bytes = TRACE_CAPACITY * sizeof *radiance;
  assert_ok(buffer_read(fixture->device, &fixture->radiance, radiance, bytes, &log), &log);
  for (uint32_t i = 0; i < TRACE_CAPACITY; i++) {
    const Float4 weight = weight_of(i), none = {0, 0, 0, 0}, *got = &radiance[slot_of(i)];
    bool lit = i < count && !memcmp(got, &weight, sizeof weight);
    if (!lit && memcmp(got, &none, sizeof none))
      fail_msg("%s: slot of ray %u of %u holds %g %g %g %g", trace_kernel_names[kernel], i, count, got->x, got->y,
               got->z, got->w);
    if (i < count) out[i] = lit;
  }
  free(radiance);
}

void trace_fixture_closest(TraceHit *out, TraceFixture *fixture, TraceKernel kernel, const TraceRay *rays,
                           uint32_t count, float t_min)
{
  for (uint32_t first = 0; first < count; first += TRACE_CAPACITY) {
    uint32_t left = count - first < TRACE_CAPACITY ? count - first : TRACE_CAPACITY;
    closest_launch(out + first, fixture, kernel, rays + first, left, t_min);
  }
}

void trace_fixture_lit(bool *out, TraceFixture *fixture, TraceKernel kernel, const TraceRay *rays, uint32_t count)
{
  for (uint32_t first = 0; first < count; first += TRACE_CAPACITY) {
    uint32_t left = count - first < TRACE_CAPACITY ? count - first : TRACE_CAPACITY;
    lit_launch(out + first, fixture, kernel, rays + first, left);
  }
}

OracleRay trace_oracle_ray(const TraceRay *ray, bool cull)
{
  OracleRay made = oracle_ray(vec3_from_floats(ray->origin), vec3_from_floats(ray->direction), 0, ray->t_max);
  made.cull = cull;
  made.start_margin = TRACE_START_MARGIN;
  made.end_margin = TRACE_END_MARGIN;
  return made;
}

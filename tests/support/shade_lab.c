#include "support/shade_lab.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

const uint32_t lab_widths[LAB_WIDTHS] = {16, 8, 1};

Vec3 lab_polar(double cosine, double azimuth_rad)
{
  double sine = sqrt(fmax(0, 1 - cosine * cosine));
  return vec3(sine * cos(azimuth_rad), sine * sin(azimuth_rad), cosine);
}

static void buffer_fill(Device *device, DeviceBuffer *buffer, const void *from)
{
  picture_assert_ok(buffer_write(device, buffer, from, buffer->bytes, &picture_log));
}

ShadeLab lab_open(const Scene *scene, uint32_t lanes)
{
  return lab_open_planned(scene, &(Plan){.environment_light = ENVIRONMENT_LIGHT_SH}, lanes);
}

static RayStream path_stream(const ShadeLab *lab)
{
  RayStream stream = {0};
  picture_assert_ok(ray_stream_make(&stream, lab->device, LAB_CAPACITY, 1, "rays", &picture_log));
  return stream;
}

ShadeLab lab_open_planned(const Scene *scene, const Plan *plan, uint32_t lanes)
{
  Log *log = &picture_log;
  *log = (Log){0};
  ShadeLab lab = {.device = picture_device(lanes), .plan = *plan};
  Device *device = lab.device;
  picture_assert_ok(device_scene_make(&lab.scene, device, scene, NULL, log));
  picture_assert_ok(shader_make(&lab.shader, device, &lab.scene, plan, log));
  lab.rays = path_stream(&lab);
  picture_assert_ok(ray_stream_make(&lab.shadow, device, LAB_CAPACITY, LIGHTS_PER_LAUNCH, "shadow rays", log));
  for (int i = 0; i < 2; i++) lab.onward[i] = path_stream(&lab);
  picture_assert_ok(hit_stream_make(&lab.hits, device, LAB_CAPACITY, log));
  picture_assert_ok(buffer_create(&lab.radiance, device, LAB_CAPACITY * sizeof(Float4), NULL, "radiance", log));
  return lab;
}

void lab_close(ShadeLab *lab)
{
  shader_free(&lab->shader);
  device_scene_free(&lab->scene);
  RayStream *streams[] = {&lab->rays, &lab->shadow, &lab->onward[0], &lab->onward[1]};
  for (size_t i = 0; i < sizeof streams / sizeof *streams; i++) ray_stream_free(streams[i]);
  hit_stream_free(&lab->hits);
  buffer_free(&lab->radiance);
}

void lab_set_hits(ShadeLab *lab, const LabHit *hits, uint32_t count)
{
  float *rays = oracle_array(LAB_CAPACITY * RAY_FIELD_COUNT, sizeof *rays);
  float *found = oracle_array(LAB_CAPACITY * HIT_FIELD_COUNT, sizeof *found);
  uint32_t *ids = oracle_array(LAB_CAPACITY, sizeof *ids), *slots = oracle_array(LAB_CAPACITY, sizeof *slots);
  assert_true(count <= LAB_CAPACITY);
  lab->count = count;
  for (uint32_t i = 0; i < LAB_CAPACITY; i++) {
    rays[RAY_T_MAX * LAB_CAPACITY + i] = -1;
    ids[i] = HIT_NONE;
    if (i >= count) continue;
    slots[i] = count - 1 - i;
    ids[i] = hits[i].triangle;
    rays[RAY_T_MAX * LAB_CAPACITY + i] = INFINITY;
    found[HIT_T * LAB_CAPACITY + i] = 1;
    found[HIT_U * LAB_CAPACITY + i] = hits[i].u;
    found[HIT_V * LAB_CAPACITY + i] = hits[i].v;
    for (int axis = 0; axis < 3; axis++) {
      rays[(RAY_DIRECTION_X + axis) * LAB_CAPACITY + i] = hits[i].direction[axis];
      rays[(RAY_WEIGHT_R + axis) * LAB_CAPACITY + i] = hits[i].weight[axis];
    }
  }
  buffer_fill(lab->device, &lab->rays.rays, rays);
  buffer_fill(lab->device, &lab->rays.slots, slots);
  buffer_fill(lab->device, &lab->hits.hits, found);
  buffer_fill(lab->device, &lab->hits.ids, ids);
  free(rays);
  free(found);
  free(ids);
  free(slots);
}

void lab_begin(ShadeLab *lab) { picture_assert_ok(buffer_zero(lab->device, &lab->radiance, &picture_log)); }

void lab_add(ShadeLab *lab, const ShadeInfo *info)
{
  ShadeStreams streams = {.rays = &lab->rays,
                          .hits = &lab->hits,
                          .shadow = &lab->shadow,
                          .reflected = &lab->onward[0],
                          .transmitted = &lab->onward[1],
                          .radiance = &lab->radiance};
  picture_assert_ok(
      shade(&lab->shader, lab->device, &lab->scene, &streams, lab->count, info, lab->counts, "shade", &picture_log));
}

void lab_end(float (*out)[4], ShadeLab *lab)
{
  float(*slots)[4] = oracle_array(LAB_CAPACITY, sizeof *slots);
  picture_assert_ok(buffer_read(lab->device, &lab->radiance, slots, lab->radiance.bytes, &picture_log));
  for (uint32_t i = 0; i < LAB_CAPACITY; i++) {
    if (i < lab->count)
      memcpy(out[i], slots[lab_ray_of_slot(lab, i)], sizeof out[i]);
    else if (slots[i][0] != 0 || slots[i][3] != 0)
      fail_msg("slot %u belongs to no ray and holds %g", i, slots[i][0]);
  }
  free(slots);
}

void lab_shade(float (*out)[4], ShadeLab *lab, const ShadeInfo *info)
{
  lab_begin(lab);
  lab_add(lab, info);
  if (out) lab_end(out, lab);
}

static LabRay *stream_rays(ShadeLab *lab, const RayStream *stream, uint32_t segment, uint32_t count)
{
  size_t all = stream->slots.bytes / sizeof(uint32_t);
  float *rays = oracle_array(stream->rays.bytes / sizeof(float), sizeof *rays);
  bool has_density = lab->plan.lobes && stream != &lab->shadow;
  uint32_t *slots = oracle_array(all, sizeof *slots);
  LabRay *out = oracle_array(count, sizeof *out);
  assert_true(count <= LAB_CAPACITY);
  picture_assert_ok(buffer_read(lab->device, &stream->rays, rays, stream->rays.bytes, &picture_log));
  picture_assert_ok(buffer_read(lab->device, &stream->slots, slots, stream->slots.bytes, &picture_log));
  const float *fields = rays + (size_t)segment * RAY_FIELD_COUNT * LAB_CAPACITY;
  for (uint32_t i = 0; i < count; i++) {
    for (int axis = 0; axis < 3; axis++) {
      out[i].origin[axis] = fields[(RAY_ORIGIN_X + axis) * LAB_CAPACITY + i];
      out[i].direction[axis] = fields[(RAY_DIRECTION_X + axis) * LAB_CAPACITY + i];
      out[i].weight[axis] = fields[(RAY_WEIGHT_R + axis) * LAB_CAPACITY + i];
    }
    out[i].t_max = fields[RAY_T_MAX * LAB_CAPACITY + i];
    if (has_density) out[i].density = rays[RAY_DENSITY * LAB_CAPACITY + i];
    out[i].slot = slots[segment * LAB_CAPACITY + i];
    assert_true(out[i].slot < lab->count);
  }
  free(rays);
  free(slots);
  return out;
}

LabRay *lab_shadow_rays(ShadeLab *lab, uint32_t light)
{
  return stream_rays(lab, &lab->shadow, light, lab->counts[light]);
}

LabRay *lab_environment_rays(ShadeLab *lab, uint32_t segment)
{
  return stream_rays(lab, &lab->shadow, segment, lab->counts[STREAM_COUNT_ENVIRONMENT + segment]);
}

LabRay *lab_reflected_rays(ShadeLab *lab)
{
  return stream_rays(lab, &lab->onward[0], 0, lab->counts[STREAM_COUNT_REFLECTED]);
}

LabRay *lab_transmitted_rays(ShadeLab *lab)
{
  return stream_rays(lab, &lab->onward[1], 0, lab->counts[STREAM_COUNT_TRANSMITTED]);
}

uint32_t lab_ray_of_slot(const ShadeLab *lab, uint32_t slot) { return lab->count - 1 - slot; }

OraclePoint lab_oracle_point(const OracleScene *scene, const LabHit *hit, Vec3 *view)
{
  Vec3 direction = vec3_from_floats(hit->direction);
  OracleRay ray = oracle_ray(vec3(0, 0, 0), direction, 0, INFINITY);
  OracleHit at = {.triangle = hit->triangle, .t = 1, .u = hit->u, .v = hit->v};
  if (view) *view = vec3_unit_or(vec3_neg(direction), vec3(0, 0, 1));
  return oracle_surface_at(scene, &ray, &at);
}

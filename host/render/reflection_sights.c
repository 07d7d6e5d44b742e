#include "render/reflection_sights.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "shared/stream.h"

Status reflection_sights_make(ReflectionSights *out, uint32_t capacity, Log *log)
{
  *out = (ReflectionSights){.sights = calloc(capacity, sizeof *out->sights), .capacity = capacity};
  return out->sights ? STATUS_OK : log_no_memory(log, "reflection bound");
}

void reflection_sights_free(ReflectionSights *sights)
{
  free(sights->sights);
  *sights = (ReflectionSights){0};
}

static uint32_t bits_of(float value)
{
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

static void sight_set(ReflectionSight *out, const float *fields, uint32_t capacity, float t, uint32_t met)
{
  float ray[RAY_FIELD_COUNT];
  for (uint32_t field = 0; field < RAY_FIELD_COUNT; field++) ray[field] = fields[(size_t)field * capacity];
  uint32_t source = bits_of(ray[RAY_DENSITY]);
  const bool is_axis = (source & RAY_FROM_MIRROR) && ray[RAY_T_MAX] <= 1;
  *out = (ReflectionSight){
      .is_reflected = (source & RAY_FROM_MIRROR) && !is_axis,
      .is_lobe = is_axis || !(source & RAY_FROM_MIRROR),
      .density = ray[RAY_DENSITY],
      .roughness = ray[RAY_T_MAX],
      .weight = {ray[RAY_WEIGHT_R], ray[RAY_WEIGHT_G], ray[RAY_WEIGHT_B]},
      .triangle = source & ~RAY_FROM_MIRROR,
      .origin = {(double)ray[RAY_ORIGIN_X], (double)ray[RAY_ORIGIN_Y], (double)ray[RAY_ORIGIN_Z]},
      .direction = {(double)ray[RAY_DIRECTION_X], (double)ray[RAY_DIRECTION_Y], (double)ray[RAY_DIRECTION_Z]},
      .distance = met != HIT_NONE ? (double)t : INFINITY,
      .met = met};
}

Status reflection_sights_keep(ReflectionSights *sights, Device *device, const RayStream *rays, uint32_t count,
                              const HitStream *hits, const DeviceBuffer *radiance, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t capacity = rays->capacity;
  float *fields = malloc((size_t)capacity * RAY_FIELD_COUNT * sizeof *fields), *t = malloc(count * sizeof *t);
  uint32_t *slots = malloc(count * sizeof *slots), *ids = malloc(count * sizeof *ids);
  float(*direct)[4] = malloc((size_t)capacity * sizeof *direct);
  if (!fields || !t || !slots || !ids || !direct) {
    status = log_no_memory(log, "reflection bound");
    goto done;
  }
  TRY(buffer_read(device, &rays->rays, fields, (size_t)capacity * RAY_FIELD_COUNT * sizeof *fields, log));
  TRY(buffer_read(device, &rays->slots, slots, count * sizeof *slots, log));
  TRY(buffer_read(device, radiance, direct, (size_t)capacity * sizeof *direct, log));
  if (hits) TRY(buffer_read(device, &hits->ids, ids, count * sizeof *ids, log));
  if (hits) TRY(buffer_read(device, &hits->hits, t, count * sizeof *t, log));
  for (uint32_t i = 0; i < count; i++) {
    if (slots[i] >= sights->capacity) continue;
    ReflectionSight *sight = &sights->sights[slots[i]];
    sight_set(sight, fields + i, capacity, hits ? t[i] : 0, hits ? ids[i] : HIT_NONE);
    memcpy(sight->direct, direct[slots[i]], sizeof sight->direct);
  }

done:
  free(fields);
  free(t);
  free(slots);
  free(ids);
  free(direct);
  return status;
}

Status reflection_sights_light(ReflectionSights *sights, Device *device, const DeviceBuffer *radiance, uint32_t count,
                               Log *log)
{
  Status status = STATUS_OK;
  float(*values)[4] = malloc(count * sizeof *values);
  if (!values) return log_no_memory(log, "reflection bound");
  TRY(buffer_read(device, radiance, values, count * sizeof *values, log));
  for (uint32_t i = 0; i < count && i < sights->capacity; i++)
    memcpy(sights->sights[i].radiance, values[i], sizeof values[i]);

done:
  free(values);
  return status;
}

#include "passes/ray_stream.h"

#include "shared/stream.h"

Status ray_stream_make(RayStream *out, Device *device, uint32_t capacity, uint32_t segments, const char *what, Log *log)
{
  Status status = STATUS_OK;
  RayStream stream = {.capacity = capacity};
  size_t rays = (size_t)capacity * segments;
  TRY(buffer_create(&stream.rays, device, rays * RAY_FIELD_COUNT * sizeof(float), NULL, what, log));
  TRY(buffer_create(&stream.slots, device, rays * sizeof(uint32_t), NULL, what, log));
  *out = stream;
  stream = (RayStream){0};

done:
  ray_stream_free(&stream);
  return status;
}

void ray_stream_free(RayStream *stream)
{
  buffer_free(&stream->rays);
  buffer_free(&stream->slots);
}

Status ray_stream_read(float *fields, Device *device, const RayStream *stream, uint32_t field_count, uint32_t count,
                       Log *log)
{
  const size_t row = stream->capacity * sizeof *fields;
  Status status = STATUS_OK;
  for (uint32_t field = 0; field < field_count && !status; field++)
    status = buffer_read_part(device, &stream->rays, field * row, fields + (size_t)field * count,
                              count * sizeof *fields, log);
  return status;
}

Status hit_stream_make(HitStream *out, Device *device, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  HitStream stream = {0};
  TRY(buffer_create(&stream.hits, device, (size_t)capacity * HIT_FIELD_COUNT * sizeof(float), NULL, "hits", log));
  TRY(buffer_create(&stream.ids, device, (size_t)capacity * sizeof(uint32_t), NULL, "hits", log));
  *out = stream;
  stream = (HitStream){0};

done:
  hit_stream_free(&stream);
  return status;
}

void hit_stream_free(HitStream *stream)
{
  buffer_free(&stream->hits);
  buffer_free(&stream->ids);
}

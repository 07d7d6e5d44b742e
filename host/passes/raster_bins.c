#include "passes/raster_bins.h"

#include "shared/raster.h"

Status raster_bins_make(RasterBins *out, Device *device, size_t chunks, uint32_t record_words, Log *log)
{
  Status status = STATUS_OK;
  RasterBins made = {0};
  size_t record_bytes = (RASTER_CHUNK + 1) * record_words * sizeof(uint32_t);
  size_t span_bytes = (chunks * SPAN_FIELDS + SPAN_PADDING) * sizeof(uint32_t);
  size_t list_bytes = (chunks * RASTER_CHUNK * RASTER_LARGE_BINS + LIST_PADDING) * sizeof(uint16_t);
  TRY(buffer_create(&made.records, device, chunks * record_bytes, NULL, "raster triangles", log));
  TRY(buffer_create(&made.spans, device, span_bytes, NULL, "raster triangles", log));
  TRY(buffer_create(&made.lists, device, list_bytes, NULL, "raster bins", log));
  *out = made;
  made = (RasterBins){0};

done:
  raster_bins_free(&made);
  return status;
}

Status raster_bins_divide(RasterBins *bins, Device *device, size_t chunks, size_t bin_count, Log *log)
{
  size_t bytes = chunks * (bin_count + 2) * sizeof(uint32_t);
  if (bins->starts.memory && bins->starts.bytes >= bytes) return STATUS_OK;
  buffer_free(&bins->starts);
  return buffer_create(&bins->starts, device, bytes, NULL, "raster bins", log);
}

void raster_bins_free(RasterBins *bins)
{
  buffer_free(&bins->records);
  buffer_free(&bins->spans);
  buffer_free(&bins->starts);
  buffer_free(&bins->lists);
}

Status raster_boxes_make(RasterBoxes *out, Device *device, size_t chunks, uint32_t tiles, Log *log)
{
  Status status = STATUS_OK;
  size_t triangles = chunks * RASTER_CHUNK, tile_bytes = RASTER_TILE_VECTORS * 4 * sizeof(uint32_t);
  RasterBoxes made = {.room = tiles};
  TRY(buffer_create(&made.boxes, device, triangles * sizeof(RasterBox), NULL, "raster triangles", log));
  TRY(buffer_create(&made.starts, device, triangles * sizeof(uint64_t), NULL, "raster triangles", log));
  TRY(buffer_create(&made.tiles, device, tiles * tile_bytes, NULL, "raster tiles", log));
  TRY(buffer_create(&made.counts, device, RASTER_BOX_COUNTS * sizeof(uint64_t), NULL, "raster tiles", log));
  *out = made;
  made = (RasterBoxes){0};

done:
  raster_boxes_free(&made);
  return status;
}

void raster_boxes_free(RasterBoxes *boxes)
{
  buffer_free(&boxes->boxes);
  buffer_free(&boxes->starts);
  buffer_free(&boxes->tiles);
  buffer_free(&boxes->counts);
}

size_t raster_box_items(const Device *device)
{
  const uint32_t per_unit = 64 * RASTER_TEAM;  // work-items of 64 warps: what a compute unit keeps at most
  return (size_t)device_info(device)->compute_units * per_unit;
}

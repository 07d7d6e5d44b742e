#include "passes/raster_bins.h"

#include "shared/raster.h"

Status raster_bins_reserve(RasterBins *bins, Device *device, size_t items, size_t bin_count, uint32_t record_words,
                           Log *log)
{
  Status status = STATUS_OK;
  size_t record_bytes = (RASTER_CHUNK + 1) * record_words * sizeof(uint32_t);
  size_t span_bytes = (items * SPAN_FIELDS + SPAN_PADDING) * sizeof(uint32_t);
  size_t list_bytes = (items * RASTER_CHUNK * RASTER_LARGE_BINS + LIST_PADDING) * sizeof(uint16_t);
  size_t start_bytes = items * (bin_count + 2) * sizeof(uint32_t);
  TRY(buffer_reserve(&bins->records, device, items * record_bytes, "raster triangles", log));
  TRY(buffer_reserve(&bins->spans, device, span_bytes, "raster triangles", log));
  TRY(buffer_reserve(&bins->starts, device, start_bytes, "raster bins", log));
  TRY(buffer_reserve(&bins->lists, device, list_bytes, "raster bins", log));

done:
  return status;
}

void raster_bins_free(RasterBins *bins)
{
  buffer_free(&bins->records);
  buffer_free(&bins->spans);
  buffer_free(&bins->starts);
  buffer_free(&bins->lists);
}

Status raster_boxes_reserve(RasterBoxes *boxes, Device *device, size_t items, uint32_t tiles, Log *log)
{
  Status status = STATUS_OK;
  size_t triangles = items * RASTER_CHUNK, tile_bytes = RASTER_TILE_VECTORS * 4 * sizeof(uint32_t);
  boxes->room = tiles;
  TRY(buffer_reserve(&boxes->boxes, device, triangles * sizeof(RasterBox), "raster triangles", log));
  TRY(buffer_reserve(&boxes->starts, device, triangles * sizeof(uint64_t), "raster triangles", log));
  TRY(buffer_reserve(&boxes->tiles, device, tiles * tile_bytes, "raster tiles", log));
  if (!boxes->counts.memory) {
    TRY(buffer_create(&boxes->counts, device, 2 * RASTER_BOX_COUNTS * sizeof(uint64_t), NULL, "raster tiles", log));
    TRY(buffer_zero(device, &boxes->counts, log));
  }

done:
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

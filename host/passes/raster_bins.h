// What both rasters keep of one pass, on the device.
#pragma once

#include "device/device.h"

// The bins' way: records of triangles by item (a chunk in a view), and their numbers by bin (cl/lib/bins.cl).
typedef struct RasterBins {
  DeviceBuffer records;  // [items][RASTER_CHUNK + 1][record_words]
  DeviceBuffer spans;    // SPAN_*, [SPAN_FIELDS][items], and padding
  DeviceBuffer starts;   // [items][bins + 2]
  DeviceBuffer lists;    // 16-bit numbers [items][RASTER_CHUNK * RASTER_LARGE_BINS], and padding
} RasterBins;

// Makes room for so many items and bins, where it is not there yet. Errors: those of buffer_create.
Status raster_bins_reserve(RasterBins *bins, Device *device, size_t items, size_t bin_count, uint32_t record_words,
                           Log *log);
void raster_bins_free(RasterBins *bins);

// In the order in which the kernels declare them.
#define BIN_ARGS(bins) \
  ARG_BUFFER((bins)->records), ARG_BUFFER((bins)->spans), ARG_BUFFER((bins)->starts), ARG_BUFFER((bins)->lists)

// The direct way: lists of triangles that are not small (cl/lib/boxes.cl).
typedef struct RasterBoxes {
  DeviceBuffer boxes;   // RasterBox, to split; room for every triangle of the pass
  DeviceBuffer starts;  // 64-bit number of the first tile of each
  DeviceBuffer tiles;   // [room] of RASTER_TILE_VECTORS x 4 words
  DeviceBuffer counts;  // two sets of RASTER_BOX_COUNTS, of 64 bits each; a pass clears that of the next
  uint32_t room, set;   // set: of the pass
} RasterBoxes;

// Makes room for so many items and tiles, where it is not there yet: there may be more tiles, which are drawn slowly.
// Errors: those of buffer_create.
Status raster_boxes_reserve(RasterBoxes *boxes, Device *device, size_t items, uint32_t tiles, Log *log);
void raster_boxes_free(RasterBoxes *boxes);

// Work-items that go through a list: as many as fill the device.
size_t raster_box_items(const Device *device);

// In the order in which the kernels declare them.
#define BOX_ARGS(list)                                                                                          \
  ARG_BUFFER((list)->boxes), ARG_BUFFER((list)->starts), ARG_BUFFER((list)->tiles), ARG_BUFFER((list)->counts), \
      ARG((list)->room), ARG((list)->set)

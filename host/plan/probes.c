#include "plan/probes.h"

#include <math.h>
#include <stdlib.h>

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

// From Jarzynski, Olano, "Hash Functions for GPU Rendering", JCGT 2020 (pcg3d).
static void hash_pcg3(uint32_t v[3])
{
  for (int i = 0; i < 3; i++) v[i] = v[i] * 1664525u + 1013904223u;
  for (int round = 0; round < 2; round++) {
    v[0] += v[1] * v[2];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
    for (int i = 0; i < 3 && round == 0; i++) v[i] ^= v[i] >> 16;
  }
}

// Tile that holds a pixel.
static Probe probe_at(uint32_t x, uint32_t y, uint32_t width, uint32_t height)
{
  uint32_t left = x / PROBE_SIDE * PROBE_SIDE, top = y / PROBE_SIDE * PROBE_SIDE;
  return (Probe){
      .x = left, .y = top, .width = smaller(PROBE_SIDE, width - left), .height = smaller(PROBE_SIDE, height - top)};
}

// First pixel of stratum `index` of `count` along a side.
static uint32_t stratum_begin(uint32_t side, uint32_t index, uint32_t count)
{
  return (uint32_t)((uint64_t)side * index / count);
}

static Probe stratum_probe(uint32_t width, uint32_t height, uint32_t column, uint32_t columns, uint32_t row,
                           uint32_t rows, uint32_t seed)
{
  uint32_t random[3] = {column, row, seed};
  hash_pcg3(random);
  uint32_t left = stratum_begin(width, column, columns), right = stratum_begin(width, column + 1, columns);
  uint32_t top = stratum_begin(height, row, rows), bottom = stratum_begin(height, row + 1, rows);
  uint32_t x = left + (uint32_t)((uint64_t)random[0] * (right - left) >> 32);
  uint32_t y = top + (uint32_t)((uint64_t)random[1] * (bottom - top) >> 32);
  Probe probe = probe_at(x, y, width, height);
  probe.weight = (double)(right - left) * (bottom - top) / ((double)width * height);
  return probe;
}

Status probes_choose(ProbeSet *out, uint32_t width, uint32_t height, uint64_t pixels, uint32_t seed, Log *log)
{
  uint32_t across = (width + PROBE_SIDE - 1) / PROBE_SIDE, down = (height + PROBE_SIDE - 1) / PROBE_SIDE;
  uint64_t tiles = (uint64_t)across * down, wanted = (pixels + PROBE_SIDE * PROBE_SIDE - 1) / (PROBE_SIDE * PROBE_SIDE);
  uint32_t columns = across, rows = down;
  bool all = wanted >= tiles;
  if (!all) {
    columns = smaller(across, (uint32_t)ceil(sqrt((double)wanted * width / height)));
    rows = smaller(down, (uint32_t)((wanted + columns - 1) / columns));
    columns = smaller(across, (uint32_t)((wanted + rows - 1) / rows));
    all = columns == across && rows == down;
  }
  ProbeSet set = {.probes = malloc((size_t)columns * rows * sizeof *set.probes), .all = all};
  if (!set.probes) return log_no_memory(log, "probes");
  for (uint32_t row = 0; row < rows; row++)
    for (uint32_t column = 0; column < columns; column++) {
      Probe probe = probe_at(column * PROBE_SIDE, row * PROBE_SIDE, width, height);
      probe.weight = (double)probe.width * probe.height / ((double)width * height);
      set.probes[set.count++] = all ? probe : stratum_probe(width, height, column, columns, row, rows, seed);
    }
  *out = set;
  return STATUS_OK;
}

void probes_free(ProbeSet *set)
{
  free(set->probes);
  *set = (ProbeSet){0};
}

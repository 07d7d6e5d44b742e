#include "report/probe_error.h"

#include <math.h>
#include <stdlib.h>

#include "report/image_compare.h"

enum { OFF, DARK, LIGHT, WEIGHT, COLUMNS };

static void pixel_add(double row[COLUMNS], const float *a, const float *b)
{
  bool off = false;
  double lighter = 0;
  for (int c = 0; c < 4; c++) {
    double difference = (double)a[c] - (double)b[c];
    off |= !(fabs(difference) <= IMAGE_THRESHOLD + IMAGE_ROUNDING);
    if (c < 3) lighter += difference;
  }
  row[OFF] += off;
  row[DARK] += off && lighter < 0;
  row[LIGHT] += off && !(lighter < 0);
}

// One probe's row; returns how many of its pixels count.
static uint32_t probe_measure(double row[COLUMNS], const float *picture, const float *reference, const bool *counted,
                              uint32_t width, const Probe *probe)
{
  uint32_t pixels = probe->width * probe->height, count = 0;
  for (uint32_t p = 0; p < pixels; p++) {
    size_t at = (size_t)(probe->y + p / probe->width) * width + probe->x + p % probe->width;
    if (counted && !counted[at]) continue;
    pixel_add(row, picture + 4 * at, reference + 4 * at);
    count++;
  }
  for (int column = 0; column < WEIGHT && count > 0; column++) row[column] /= count;
  row[WEIGHT] = probe->weight * count / pixels;
  return count;
}

// A probe of which no pixel counts is none.
Status probe_error_make(ProbeError *out, const float *picture, const float *reference, const bool *counted,
                        uint32_t width, const ProbeSet *set, Log *log)
{
  uint32_t clusters = 0;
  double(*rows)[COLUMNS] = calloc(set->count + 1, sizeof *rows);
  *out = (ProbeError){0};
  if (!rows) return log_no_memory(log, "probes");
  for (uint32_t i = 0; i < set->count; i++) {
    uint32_t count = probe_measure(rows[clusters], picture, reference, counted, width, &set->probes[i]);
    out->pixels += count;
    clusters += count > 0;
  }
  Proportion *const shares[] = {&out->off, &out->dark, &out->light};
  for (int column = 0; column < WEIGHT; column++)
    *shares[column] =
        proportion_of_clusters(&rows[0][column], &rows[0][WEIGHT], COLUMNS, clusters, (double)out->pixels, set->all);
  free(rows);
  return STATUS_OK;
}

static bool is_edge(const float *lit, uint32_t width, const Probe *probe, uint32_t x, uint32_t y)
{
  float own = lit[(size_t)y * width + x];
  for (uint32_t j = y > probe->y ? y - 1 : y; j <= y + 1 && j < probe->y + probe->height; j++)
    for (uint32_t i = x > probe->x ? x - 1 : x; i <= x + 1 && i < probe->x + probe->width; i++)
      if (fabsf(lit[(size_t)j * width + i] - own) > PROBE_EDGE) return true;
  return false;
}

void probe_edges(bool *out, const float *lit, uint32_t width, const ProbeSet *set)
{
  for (uint32_t i = 0; i < set->count; i++) {
    const Probe *probe = &set->probes[i];
    for (uint32_t y = probe->y; y < probe->y + probe->height; y++)
      for (uint32_t x = probe->x; x < probe->x + probe->width; x++)
        out[(size_t)y * width + x] = is_edge(lit, width, probe, x, y);
  }
}

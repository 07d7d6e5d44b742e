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

Status probe_error_make(ProbeError *out, const float *picture, const float *reference, uint32_t width,
                        const ProbeSet *set, Log *log)
{
  double(*rows)[COLUMNS] = calloc(set->count, sizeof *rows);
  *out = (ProbeError){0};
  if (!rows) return log_no_memory(log, "probes");
  for (uint32_t i = 0; i < set->count; i++) {
    const Probe *probe = &set->probes[i];
    uint32_t pixels = probe->width * probe->height;
    for (uint32_t p = 0; p < pixels; p++) {
      size_t at = (size_t)(probe->y + p / probe->width) * width + probe->x + p % probe->width;
      pixel_add(rows[i], picture + 4 * at, reference + 4 * at);
    }
    for (int column = 0; column < WEIGHT; column++) rows[i][column] /= pixels;
    rows[i][WEIGHT] = probe->weight;
    out->pixels += pixels;
  }
  Proportion *const shares[] = {&out->off, &out->dark, &out->light};
  for (int column = 0; column < WEIGHT; column++)
    *shares[column] =
        proportion_of_clusters(&rows[0][column], &rows[0][WEIGHT], COLUMNS, set->count, (double)out->pixels, set->all);
  free(rows);
  return STATUS_OK;
}

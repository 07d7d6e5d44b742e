#include "stability/stability.h"

#include <stdlib.h>

static const double warning_slack = 4;

const StabilityTable *const stability_tables[STABILITY_TABLES] = {&shadow_table, &reflection_table, &geometry_table};

static bool is_over(const StabilityPoint *point) { return !(point->measured <= point->bound); }

static int double_compare(const void *a, const void *b)
{
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

Verdict stability_verdict(const StabilityPoint *points, uint32_t count)
{
  double ratios[STABILITY_POINTS_MOST];
  uint32_t over = 0;
  for (uint32_t i = 0; i < count; i++) {
    if (!is_over(&points[i])) continue;
    if (i == 0 || !(points[i].measured <= points[i].warned)) return VERDICT_SILENT;
    ratios[over++] = points[i].warned / points[i].measured;
  }
  if (over == 0) return VERDICT_HOLDS;
  qsort(ratios, over, sizeof *ratios, double_compare);
  return ratios[over / 2] <= warning_slack ? VERDICT_SAYS_SO : VERDICT_SILENT;
}

// Grows with the share of the bound; most where there is no number.
static double badness(const StabilityPoint *point)
{
  if (!isfinite(point->measured)) return INFINITY;
  double share = point->bound > 0 ? point->measured / point->bound : point->measured > 0 ? 1e9 * point->measured : 0;
  return isfinite(share) ? share : 1e30;
}

uint32_t stability_worst(const StabilityPoint *points, uint32_t count)
{
  uint32_t worst = 0;
  for (uint32_t i = 1; i < count; i++)
    if (badness(&points[i]) >= badness(&points[worst])) worst = i;
  return worst;
}

const char *stability_verdict_name(Verdict verdict)
{
  static const char *const names[] = {"holds", "says so", "silent"};
  return names[verdict];
}

const char *stability_method_name(const StabilityRow *row, ShadowMethod method)
{
  return row->methods ? shadow_words[method] : "-";
}

bool stability_row_has(const StabilityRow *row, ShadowMethod method)
{
  return row->methods ? row->methods >> method & 1 : method == SHADOWS_RAYS;
}

Status stability_measure(StabilityCurve *out, Lab *lab, const StabilityRow *row, ShadowMethod method)
{
  Status status = STATUS_OK;
  StabilityCurve curve = {0};
  for (uint32_t i = 0; i < row->sweep.count; i++) {
    if (lab->quick && !(row->sweep.quick >> i & 1)) continue;
    StabilityPoint *point = &curve.points[curve.count];
    *point = (StabilityPoint){.value = row->sweep.values[i]};
    TRY(row->measure(point, lab, method));
    if (stability_worst(curve.points, curve.count + 1) == curve.count) {
      lab_pictures_free(&curve.pictures);
      curve.pictures = lab->pictures;
      lab->pictures = (LabPictures){0};
    }
    curve.count++;
  }
  curve.worst = stability_worst(curve.points, curve.count);
  curve.verdict = stability_verdict(curve.points, curve.count);
  *out = curve;
  curve = (StabilityCurve){0};

done:
  lab_pictures_free(&lab->pictures);
  stability_curve_free(&curve);
  return status;
}

void stability_curve_free(StabilityCurve *curve) { lab_pictures_free(&curve->pictures); }

// The catalogue of failures: for each a scene that triggers it, a sweep, what is measured, and the bound that it must
// stay under.
#pragma once

#include "stability/lab.h"

typedef struct StabilityPoint {
  double value;     // of the row's parameter
  double measured;  // not finite: something came out that is no number
  double bound;     // that the row states; INFINITY: the curve is shown and nothing promised
  double warned;    // what the method itself says that it may be off by, where that is more
} StabilityPoint;

typedef enum Verdict {
  VERDICT_HOLDS,    // within the bound everywhere
  VERDICT_SAYS_SO,  // not, but where it is not, the method says so
  VERDICT_SILENT,   // beyond both
} Verdict;

enum { STABILITY_POINTS_MOST = 16 };

// Values of the row's parameter; the first is the easy control.
typedef struct StabilitySweep {
  double values[STABILITY_POINTS_MOST];
  uint32_t count;
  uint32_t quick;  // a bit for each value that a quick run takes
} StabilitySweep;

typedef struct StabilityRow {
  const char *name, *failure;
  const char *scene, *parameter;
  const char *quantity;  // that is measured
  const char *bound;
  uint32_t methods;  // a bit for each ShadowMethod that it is about; 0: about none
  StabilitySweep sweep;
  // Sets all of *point but the value, and may keep pictures (lab_keep). Without a method: SHADOWS_RAYS.
  Status (*measure)(StabilityPoint *point, Lab *lab, ShadowMethod method);
} StabilityRow;

typedef struct StabilityTable {
  const char *name;
  const StabilityRow *rows;
  uint32_t row_count;
} StabilityTable;

// One table a file: shadow_rows.c, reflection_rows.c, geometry_rows.c.
enum { STABILITY_TABLES = 3 };
extern const StabilityTable *const stability_tables[STABILITY_TABLES];
extern const StabilityTable shadow_table, reflection_table, geometry_table;

typedef struct StabilityCurve {
  StabilityPoint points[STABILITY_POINTS_MOST];
  uint32_t count, worst;  // as stability_worst has it
  Verdict verdict;
  LabPictures pictures;  // of the worst point; empty where the row has none
} StabilityCurve;

// SILENT where a point beyond its bound is beyond what the method warned of too, where the first point, the easy
// control, is beyond its bound, or where the warnings say little: more than 4 times the measured error in the median of
// the points beyond the bound.
Verdict stability_verdict(const StabilityPoint *points, uint32_t count);

// Index of the point nearest to its bound, or farthest beyond; of equal ones the last, which is the hardest.
uint32_t stability_worst(const StabilityPoint *points, uint32_t count);

// "holds", "says so" or "silent".
const char *stability_verdict_name(Verdict verdict);

// "map", "rays", ...; "-" for rows about no method.
const char *stability_method_name(const StabilityRow *row, ShadowMethod method);

// Is the row about this method? A row about none counts as one about SHADOWS_RAYS.
bool stability_row_has(const StabilityRow *row, ShadowMethod method);

// Runs a row's sweep. Errors: those of rendering.
Status stability_measure(StabilityCurve *out, Lab *lab, const StabilityRow *row, ShadowMethod method);
void stability_curve_free(StabilityCurve *curve);

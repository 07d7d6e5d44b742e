#include "support/ratios.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

static int double_compare(const void *a, const void *b)
{
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

void ratios_sort(double *values, int count) { qsort(values, (size_t)count, sizeof *values, double_compare); }

void ratios_report(const char *name, double *ratios, int some, int missed, int count, double missed_most)
{
  ratios_sort(ratios, some);
  assert_true(some > count / 2);
  print_message("%s: %d of %d beyond the bound; over measured: median %.2f, first and last tenth %.2f, %.2f\n", name,
                missed, count, ratios[some / 2], ratios[some / 10], ratios[some * 9 / 10]);
  assert_true(missed <= 1 + missed_most * count && ratios[some / 2] <= 4);
}

// The error that rungs with lists, and exact ones, state before they are rendered.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "render/list_bound.h"
#include "support/bound_sweep.h"
#include "support/picture_fixture.h"

static void snapshots_state_their_error(void **state) { bound_sweep(REFLECTIONS_SNAPSHOT, 1, 12); }
static void candidates_state_their_error(void **state) { bound_sweep(REFLECTIONS_CANDIDATES, 1, 12); }
static void mixtures_state_their_error(void **state) { bound_sweep(REFLECTIONS_MIXED, 1, 12); }
static void flat_mirrors_are_exact(void **state) { bound_sweep_exact(REFLECTIONS_PLANAR, EXACT_SHARE, 12); }
static void hybrids_are_exact(void **state) { bound_sweep_exact(REFLECTIONS_HYBRID, EXACT_SHARE, 12); }

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(snapshots_state_their_error), cmocka_unit_test(candidates_state_their_error),
      cmocka_unit_test(mixtures_state_their_error),  cmocka_unit_test(flat_mirrors_are_exact),
      cmocka_unit_test(hybrids_are_exact),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

// The error that maps about reflectors state before they are rendered: it covers the measured one and is not much more.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "support/bound_sweep.h"
#include "support/picture_fixture.h"

static void the_environment_states_its_error(void **state) { bound_sweep(REFLECTIONS_ENVIRONMENT, 1, 8); }
static void cubes_state_their_error(void **state) { bound_sweep(REFLECTIONS_CUBE, 1, 12); }
static void boxes_state_their_error(void **state) { bound_sweep(REFLECTIONS_BOX, 1, 12); }
static void impostors_state_their_error(void **state) { bound_sweep(REFLECTIONS_IMPOSTOR, 1, 12); }
static void rough_surfaces_state_their_error(void **state) { bound_sweep_rough(12); }

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_environment_states_its_error), cmocka_unit_test(cubes_state_their_error),
      cmocka_unit_test(boxes_state_their_error),          cmocka_unit_test(impostors_state_their_error),
      cmocka_unit_test(rough_surfaces_state_their_error),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

// Prefiltered levels of a cube map against the same sums in double precision, and against integrals.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/math3d.h"
#include "passes/cube_prefilter.h"
#include "support/picture_fixture.h"

enum { SIZE = 32, SKIPPED_TEXELS = 128, SKIPPED_LEVELS = 64 };

// ---- the same in double precision -----------------------------------------------------------------------------------

typedef struct Value {
  double v[4];
} Value;

// Radiance and 1 / distance, [6][size][size]; of the cube itself that is along the face's axis.
typedef struct Faces {
  Value *texels;
  int size;
  bool along_axis;
} Faces;

static Faces faces_make(int size)
{
  Faces faces = {calloc((size_t)(6 * size * size), sizeof *faces.texels), size, false};
  assert_non_null(faces.texels);
  return faces;
}

static Vec3 texel_direction(int size, int face, int x, int y)
{
  double a = 2.0 * x / (size - 1) - 1, b = 2.0 * y / (size - 1) - 1, s = face % 2 ? -1 : 1;
  return face < 2 ? vec3(s, a, b) : face < 4 ? vec3(b, s, a) : vec3(a, b, s);
}

static Value *texel_of(const Faces *faces, int face, int x, int y)
{
  return &faces->texels[(face * faces->size + y) * faces->size + x];
}

static Value look_up(const Faces *faces, Vec3 d)
{
  double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z), last = 0.5 * (faces->size - 1);
  bool along_x = x >= y && x >= z, along_y = !along_x && y >= z;
  double major = along_x ? d.x : along_y ? d.y : d.z;
  double a = along_x ? d.y : along_y ? d.z : d.x, b = along_x ? d.z : along_y ? d.x : d.y;
  int face = (along_x ? 0 : along_y ? 2 : 4) + (major < 0);
  double column = (a / fabs(major) + 1) * last, row = (b / fabs(major) + 1) * last;
  int left = (int)fmin(fmax(column, 0), faces->size - 2), top = (int)fmin(fmax(row, 0), faces->size - 2);
  Value out;
  for (int c = 0; c < 4; c++) {
    double across = column - left, down = row - top;
    out.v[c] = (1 - down) * ((1 - across) * texel_of(faces, face, left, top)->v[c] +
                             across * texel_of(faces, face, left + 1, top)->v[c]) +
               down * ((1 - across) * texel_of(faces, face, left, top + 1)->v[c] +
                       across * texel_of(faces, face, left + 1, top + 1)->v[c]);
  }
  if (faces->along_axis) out.v[3] *= fabs(major) / vec3_length(d);
  return out;
}

static void tangents(Vec3 n, Vec3 *across, Vec3 *down)
{
  const Vec3 up = {0, 0, 1}, other = fabs(n.z) < 0.9 ? up : vec3(1, 0, 0);
  *across = vec3_unit_or(vec3_cross(other, n), up);
  *down = vec3_cross(n, *across);
}

static Vec3 in_frame(Vec3 n, double x, double y, double z)
{
  Vec3 across, down;
  tangents(n, &across, &down);
  return vec3_add(vec3_add(vec3_scale(across, x), vec3_scale(down, y)), vec3_scale(n, z));
}

static Faces halved(const Faces *from)
{
  Faces out = faces_make(from->size / 2);
  for (int i = 0; i < 6 * out.size * out.size; i++) {
    int face = i / (out.size * out.size), y = i / out.size % out.size, x = i % out.size;
    Vec3 d = texel_direction(out.size, face, x, y), n = vec3_unit_or(d, d);
    double quarter = 0.5 / (out.size - 1) / pow(vec3_dot(d, d), 0.75);
    for (int k = 0; k < 4; k++) {
      Value value = look_up(from, in_frame(n, k % 2 ? quarter : -quarter, k / 2 ? quarter : -quarter, 1));
      for (int c = 0; c < 4; c++) out.texels[i].v[c] += 0.25 * value.v[c];
    }
  }
  return out;
}

// ---- what is filtered -----------------------------------------------------------------------------------------------

// A ramp, stripes with edges, and a lamp; everything 2 metres away from the centre.
static Value scene_value(Vec3 d)
{
  double lamp = vec3_dot(d, vec3_unit_or(vec3(1, 0.9, 0.2), d));
  return (Value){{1 + d.x, sin(9 * d.x) * sin(7 * d.y + 1) > 0.3 ? 4 : 0.1, lamp > 0.98 ? 50 : 0.5, 0.5}};
}

typedef struct Filtered {
  float (*levels)[4];
  uint32_t count;
} Filtered;

static CubeInfo cube_info(void)
{
  return (CubeInfo){.size = SIZE, .first_texel = SKIPPED_TEXELS, .first_level = SKIPPED_LEVELS};
}

// All levels, by the device.
static Filtered filter(uint32_t lanes, Value (*value_of)(Vec3 d))
{
  Device *device = picture_device(lanes);
  CubePrefilter prefilter = {0};
  DeviceBuffer texels = {0}, levels = {0};
  const CubeInfo cube = cube_info();
  const uint32_t texel_count = SKIPPED_TEXELS + CUBE_TEXELS(SIZE);
  Filtered out = {.count = cube_level_first(cube_level_count(SIZE), SIZE)};
  const uint32_t all = SKIPPED_LEVELS + out.count;
  float(*given)[4] = calloc(texel_count, sizeof *given), (*got)[4] = calloc(all, sizeof *got);
  out.levels = calloc(out.count, sizeof *out.levels);
  assert_true(given && got && out.levels);
  for (int i = 0; i < 6 * SIZE * SIZE; i++) {
    Vec3 d = texel_direction(SIZE, i / (SIZE * SIZE), i % SIZE, i / SIZE % SIZE), n = vec3_unit_or(d, d);
    Value value = value_of(n);
    for (int c = 0; c < 3; c++) given[SKIPPED_TEXELS + i][c] = (float)value.v[c];
    given[SKIPPED_TEXELS + i][3] = (float)(value.v[3] * vec3_length(d));  // along the face's axis
  }
  picture_assert_ok(cube_prefilter_make(&prefilter, device, SIZE, &picture_log));
  picture_assert_ok(buffer_create(&texels, device, texel_count * sizeof *given, given, "texels", &picture_log));
  picture_assert_ok(buffer_create(&levels, device, all * sizeof *got, got, "levels", &picture_log));
  picture_assert_ok(cube_prefilter(&prefilter, device, &cube, &texels, &levels, &picture_log));
  picture_assert_ok(buffer_read(device, &levels, got, all * sizeof *got, &picture_log));
  for (uint32_t i = 0; i < all; i++)
    for (int c = 0; c < 4; c++) {
      if (i >= SKIPPED_LEVELS) out.levels[i - SKIPPED_LEVELS][c] = got[i][c];
      if (i < SKIPPED_LEVELS && (got[i][c] < 0 || got[i][c] > 0)) fail_msg("level texel %u is another cube's", i);
    }
  cube_prefilter_free(&prefilter);
  buffer_free(&texels);
  buffer_free(&levels);
  free(given);
  free(got);
  return out;
}

static const uint32_t widths[] = {0, 8, 1};

// ---- tests ----------------------------------------------------------------------------------------------------------

static void level_check(const Filtered *got, uint32_t level, const Faces *images, int image_count, uint32_t lanes)
{
  PrefilterSample samples[256];
  const int size = (int)cube_level_size(level, SIZE);
  const uint32_t first = cube_level_first(level, SIZE);
  cube_level_samples_fill(samples, level);
  for (int i = 0; i < 6 * size * size; i++) {
    Vec3 d = texel_direction(size, i / (size * size), i % size, i / size % size), n = vec3_unit_or(d, d);
    double wanted[4] = {0};
    for (uint32_t k = 0; k < cube_level_samples(level); k++) {
      const PrefilterSample *s = &samples[k];
      int image = (int)fmin(fmax(rint((double)s->halvings + log2(SIZE)), 0), image_count - 1);
      Value value = look_up(&images[image], in_frame(n, (double)s->x, (double)s->y, (double)s->z));
      for (int c = 0; c < 4; c++) wanted[c] += (double)s->weight * value.v[c];
    }
    for (int c = 0; c < 4; c++) {
      double value = (double)got->levels[first + (uint32_t)i][c];
      if (!(fabs(value - wanted[c]) <= 2e-4 * (wanted[c] + 0.1)))
        fail_msg("%u lanes, level %u, texel %d, channel %d: %g, not %g", lanes, level, i, c, value, wanted[c]);
    }
  }
}

static void levels_are_those_of_double_precision(void **state)
{
  Faces images[8] = {faces_make(SIZE)};
  int image_count = 1;
  for (int i = 0; i < 6 * SIZE * SIZE; i++) {
    Vec3 d = texel_direction(SIZE, i / (SIZE * SIZE), i % SIZE, i / SIZE % SIZE);
    images[0].texels[i] = scene_value(vec3_unit_or(d, d));
    images[0].texels[i].v[3] *= vec3_length(d);
  }
  images[0].along_axis = true;
  for (; images[image_count - 1].size / 2 >= CUBE_SMALLEST_IMAGE_PX; image_count++)
    images[image_count] = halved(&images[image_count - 1]);
  for (int w = 0; w < 3; w++) {
    Filtered got = filter(widths[w], scene_value);
    for (uint32_t level = 0; level < cube_level_count(SIZE); level++)
      level_check(&got, level, images, image_count, widths[w]);
    free(got.levels);
  }
  for (int i = 0; i < image_count; i++) free(images[i].texels);
}

// The mean of l.n over the lobe: l has density D(h) / 4, weighted by n.l, the half vector's cosine is that of half the
// angle.
static double lobe_mean_cosine(double alpha)
{
  enum { STEPS = 200000 };
  double sum = 0, weights = 0;
  for (int i = 0; i < STEPS; i++) {
    double c = (i + 0.5) / STEPS, d = 1 + (alpha * alpha - 1) * (1 + c) / 2, weight = c / (d * d);
    sum += weight * c;
    weights += weight;
  }
  return sum / weights;
}

// What changes linearly with the direction comes out as the lobe's mean cosine says.
static void a_ramp_is_flattened_as_the_lobe_is_wide(void **state)
{
  Filtered got = filter(0, scene_value);
  for (uint32_t level = 0; level < cube_level_count(SIZE); level++) {
    const int size = (int)cube_level_size(level, SIZE);
    double slope = lobe_mean_cosine(exp2(-(double)level)), worst = 0;
    for (int i = 0; i < 6 * size * size; i++) {
      Vec3 d = texel_direction(size, i / (size * size), i % size, i / size % size), n = vec3_unit_or(d, d);
      double value = (double)got.levels[cube_level_first(level, SIZE) + (uint32_t)i][0];
      worst = fmax(worst, fabs(value - (1 + slope * n.x)));
    }
    print_message("level %u: slope %.4f, off by %.4f at worst\n", level, slope, worst);
    assert_true(worst < 0.015);
  }
  free(got.levels);
}

static Value white_value(Vec3 d) { return (Value){{1, 1, 1, 1}}; }

static void white_stays_white(void **state)
{
  Filtered got = filter(0, white_value);
  for (uint32_t i = 0; i < got.count; i++)
    for (int c = 0; c < 3; c++)
      if (!(fabs((double)got.levels[i][c] - 1) < 1e-5)) fail_msg("texel %u: %g", i, (double)got.levels[i][c]);
  free(got.levels);
}

// Faces that meet have the same texels on their edges.
static void faces_of_levels_meet(void **state)
{
  Filtered got = filter(0, scene_value);
  for (uint32_t level = 0; level < cube_level_count(SIZE); level++) {
    const int size = (int)cube_level_size(level, SIZE), count = 6 * size * size;
    float(*texels)[4] = got.levels + cube_level_first(level, SIZE);
    int met = 0;
    for (int i = 0; i < count; i++)
      for (int k = i + 1; k < count; k++) {
        Vec3 a = texel_direction(size, i / (size * size), i % size, i / size % size),
             b = texel_direction(size, k / (size * size), k % size, k / size % size);
        if (vec3_length(vec3_sub(a, b)) > 1e-9) continue;
        met++;
        for (int c = 0; c < 4; c++)
          if (!(fabs((double)(texels[i][c] - texels[k][c])) <= 1e-4 * (double)texels[i][c]))
            fail_msg("level %u, texels %d and %d: %g, %g", level, i, k, (double)texels[i][c], (double)texels[k][c]);
      }
    assert_int_equal(met, 12 * (size - 2) + 8 * 3);
  }
  free(got.levels);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(levels_are_those_of_double_precision),
      cmocka_unit_test(a_ramp_is_flattened_as_the_lobe_is_wide),
      cmocka_unit_test(white_stays_white),
      cmocka_unit_test(faces_of_levels_meet),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

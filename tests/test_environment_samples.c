// Where surfaces look for the environment's light, and what they expect to find there: the directions that
// cl/shade/shade.cl chooses, against the densities that it says they have and integrals of the published formulas.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/histogram.h"
#include "support/oracle_environment.h"
#include "support/shade_lab.h"

// ---- surfaces -------------------------------------------------------------------------------------------------------

// Each ray of a launch hits a surface by its number. The first two face up and down and are too rough to reflect the
// scene; the third is a mirror; the others reflect in lobes.
enum { FACES_UP, FACES_DOWN, IS_MIRROR, LOBES, CLASSES = 10, LAUNCHES = 256, RAYS = LAB_CAPACITY / 16 * 16 };
static const int class_of_ray[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 3, 4, 5, 6, 7, 8, 9};
static const double max_roughness = 0.95, rotation_rad = 0.7, intensity = 2;
static const double lobe_roughnesses[] = {0.15, 0.3, 0.6, 0.9}, lobe_cosines[] = {0.9, 0.3};

static double roughness_of(int kind)
{
  return kind == IS_MIRROR ? 0 : kind < LOBES ? 1 : lobe_roughnesses[(kind - LOBES) % 4];
}
static double cosine_of(int kind) { return kind < LOBES ? 0.7 : lobe_cosines[(kind - LOBES) / 4]; }
static double up_of(int kind) { return kind == FACES_DOWN ? -1 : 1; }

static Vec3 view_of(int kind)
{
  double cosine = cosine_of(kind), sine = sqrt(1 - cosine * cosine);
  return vec3(sine * cos(0.4), up_of(kind) * cosine, sine * sin(0.4));
}

static OracleSurface surface_of(int kind)
{
  return (OracleSurface){.base = vec3(0.9, 0.6, 0.3),
                         .alpha = 1,
                         .metallic = kind < LOBES ? 0 : 0.5,
                         .roughness = (float)roughness_of(kind),
                         .occlusion = 1};
}

enum { IMAGE_WIDTH = 48, IMAGE_HEIGHT = 20 };

// Noise, a black part, and a pixel that has most of the light.
static void picture_set(Scene *scene)
{
  float colors[IMAGE_WIDTH * IMAGE_HEIGHT][3];
  for (int i = 0; i < IMAGE_WIDTH * IMAGE_HEIGHT; i++) {
    double x = i % IMAGE_WIDTH, y = i / IMAGE_WIDTH;
    for (int c = 0; c < 3; c++) colors[i][c] = (float)(x < 6 ? 0 : 0.6 + 0.5 * sin(2.1 * x + c) * cos(1.7 * y + 2 * c));
  }
  colors[5 * IMAGE_WIDTH + 30][0] = 400;
  colors[5 * IMAGE_WIDTH + 30][1] = 350;
  colors[5 * IMAGE_WIDTH + 30][2] = 250;
  scene_set_image(scene, IMAGE_WIDTH, IMAGE_HEIGHT, (const float(*)[3])colors);
  scene->environment.rotation_rad = rotation_rad;
  scene->environment.intensity = (float)intensity;
}

// A few pixels: the rows at the poles are half of all directions.
static void small_picture_set(Scene *scene, uint32_t width, uint32_t height)
{
  float colors[6][3];
  assert_true(width * height <= 6);
  for (uint32_t i = 0; i < width * height; i++)
    for (int c = 0; c < 3; c++) colors[i][c] = (float)(1 + i * 7 % 5 + c);
  scene_set_image(scene, width, height, (const float(*)[3])colors);
}

static Scene surfaces_scene(void)
{
  Scene scene = scene_empty();
  for (int kind = 0; kind < CLASSES; kind++) {
    OracleSurface surface = surface_of(kind);
    Vec3 normal = vec3(0, up_of(kind), 0);
    const Vec3 corners[3] = {vec3(-1, 0, up_of(kind)), vec3(1, 0, up_of(kind)), vec3(0, 0, -up_of(kind))};
    int material = scene_add_material(&scene, material_plain(surface.base, surface.metallic, surface.roughness));
    scene_add_triangle(&scene, material, corners, (const Vec3[3]){normal, normal, normal});
  }
  picture_set(&scene);
  return scene;
}

static ShadeLab surfaces_lab(const Scene *scene, uint32_t lanes)
{
  const Plan plan = {.lobes = true,
                     .environment_light = ENVIRONMENT_LIGHT_SAMPLED,
                     .reflected_rays = true,
                     .max_roughness = (float)max_roughness,
                     .max_depth = 1};
  ShadeLab lab = lab_open_planned(scene, &plan, lanes);
  LabHit hits[RAYS];
  for (int i = 0; i < RAYS; i++) {
    int kind = class_of_ray[i % 16];
    Vec3 view = view_of(kind);
    hits[i] = (LabHit){.triangle = (uint32_t)kind,
                       .u = 0.25f,
                       .v = 0.25f,
                       .direction = {(float)-view.x, (float)-view.y, (float)-view.z},
                       .weight = {1, 1, 1}};
  }
  lab_set_hits(&lab, hits, RAYS);
  return lab;
}

static ShadeInfo launch_info(uint32_t launch)
{
  return (ShadeInfo){.model = LIGHTING_MODEL_PBR,
                     .first_batch = 1,
                     .reflect = 1,
                     .environment_light = ENVIRONMENT_BY_SAMPLES,
                     .max_roughness = (float)max_roughness,
                     .environment_open = 2,
                     .environment_table = 1,
                     .random_key = launch * 7919,
                     .tile_count = RAYS / 64,
                     .tiles_per_row = 8,
                     .tile_rows = RAYS / 64 / 8};
}

static int class_of(const ShadeLab *lab, const LabRay *ray)
{
  return class_of_ray[lab_ray_of_slot(lab, ray->slot) % 16];
}

static uint32_t samples_of(int kind, uint32_t launches)
{
  uint32_t count = 0;
  for (int i = 0; i < 16; i++) count += class_of_ray[i] == kind;
  return count * (RAYS / 16) * launches;
}

// ---- densities ------------------------------------------------------------------------------------------------------

static double luminance(Vec3 c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// Luminance, with sin(theta) replaced by its mean over a row of cells: between the middles of two rows of pixels, or of
// one and the pole.
typedef struct ImageDensity {
  const Environment *environment;
  double total;
} ImageDensity;

static double image_weight(const Environment *environment, Vec3 direction)
{
  double height = environment->image.height, theta = acos(fmax(-1, fmin(1, direction.y)));
  double row = floor(theta / M_PI * height + 0.5);
  double top = fmax(row - 0.5, 0) * M_PI / height, bottom = fmin(row + 0.5, height) * M_PI / height;
  double mean_sine = (cos(top) - cos(bottom)) / (bottom - top);
  return luminance(oracle_environment(environment, direction)) * mean_sine / sin(theta);
}

static ImageDensity image_density_make(const Environment *environment)
{
  enum { ACROSS = 1200, DOWN = 1000 };
  ImageDensity density = {.environment = environment};
  for (int row = 0; row < DOWN; row++) {
    for (int column = 0; column < ACROSS; column++) {
      double theta = M_PI * (row + 0.5) / DOWN, phi = 2 * M_PI * (column + 0.5) / ACROSS;
      Vec3 direction = vec3(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi));
      density.total += image_weight(environment, direction) * sin(theta) * (2 * M_PI * M_PI / ACROSS / DOWN);
    }
  }
  return density;
}

static double image_density(const void *context, int kind, Vec3 direction)
{
  const ImageDensity *image = context;
  return image_weight(image->environment, direction) / image->total;
}

static double cosine_density(const void *context, int kind, Vec3 direction) { return fabs(direction.y) / M_PI; }

// Reflections at normals that the eye sees: G1 D / (4 n.v), Heitz 2018, equation 17 at 3.
static double lobe_density(const void *context, int kind, Vec3 direction)
{
  Vec3 view = view_of(kind), h = vec3_unit_or(vec3_add(view, direction), view);
  double alpha = roughness_of(kind) * roughness_of(kind), cosine = cosine_of(kind), c2 = cosine * cosine;
  double lambda = (sqrt(1 + alpha * alpha * (1 - c2) / c2) - 1) / 2;
  return oracle_ggx(h.y, alpha) / ((1 + lambda) * 4 * cosine);
}

static void histogram_check(const char *what, int kind, const Histogram *histogram)
{
  double z = histogram_chi_square_z(histogram), sum = 0;
  for (int cell = 0; cell < HISTOGRAM_CELLS; cell++) sum += histogram->got[cell];
  print_message("%s, roughness %g, n.v %g: %.0f samples, z = %.2f\n", what, roughness_of(kind), cosine_of(kind), sum,
                z);
  if (!(fabs(z) < 4.5)) fail_msg("%s: not the density that was said: z = %g", what, z);
}

// ---- the tests ------------------------------------------------------------------------------------------------------

typedef struct Counted {
  Histogram image[2], cosine, lobes[CLASSES];
  double to_specular[CLASSES];  // share of the samples that go to the lobe; 0: no ray of it was seen yet
} Counted;

static Vec3 direction_of(const LabRay *ray) { return vec3_from_floats(ray->direction); }

// The density that a reflected ray carries is that of its lobe times the lobe's share, the same for every ray.
static void lobes_count(Counted *counted, ShadeLab *lab)
{
  LabRay *rays = lab_reflected_rays(lab);
  for (uint32_t i = 0; i < lab->counts[STREAM_COUNT_REFLECTED]; i++) {
    int kind = class_of(lab, &rays[i]);
    Vec3 direction = direction_of(&rays[i]);
    if (kind == IS_MIRROR) {
      assert_true(isinf(rays[i].density));
      continue;
    }
    assert_true(kind >= LOBES);
    assert_true(fabs(vec3_length(direction) - 1) < 1e-5);
    counted->lobes[kind].got[histogram_cell(direction)]++;
    double share = rays[i].density / lobe_density(NULL, kind, direction), *known = &counted->to_specular[kind];
    if (*known == 0) *known = share;
    if (!(fabs(share / *known - 1) < 1e-3))
      fail_msg("roughness %g: a share of %g, then of %g", roughness_of(kind), *known, share);
  }
  free(rays);
}

static void environment_rays_count(Counted *counted, ShadeLab *lab)
{
  LabRay *rays = lab_environment_rays(lab, ENVIRONMENT_RAYS_IMAGE);
  for (uint32_t i = 0; i < lab->counts[STREAM_COUNT_ENVIRONMENT + ENVIRONMENT_RAYS_IMAGE]; i++) {
    int kind = class_of(lab, &rays[i]);
    assert_true(fabs(vec3_length(direction_of(&rays[i])) - 1) < 1e-5);
    if (kind <= FACES_DOWN) counted->image[kind].got[histogram_cell(direction_of(&rays[i]))]++;
  }
  free(rays);
  rays = lab_environment_rays(lab, ENVIRONMENT_RAYS_LOBE);
  for (uint32_t i = 0; i < lab->counts[STREAM_COUNT_ENVIRONMENT + ENVIRONMENT_RAYS_LOBE]; i++) {
    assert_true(fabs(vec3_length(direction_of(&rays[i])) - 1) < 1e-5);
    if (class_of(lab, &rays[i]) == IS_MIRROR) counted->cosine.got[histogram_cell(direction_of(&rays[i]))]++;
  }
  free(rays);
}

// Rays that would bring nothing are not sent: where the image is black, expect none from the lobes.
static double seen_cosine_density(const void *context, int kind, Vec3 direction)
{
  return image_density(context, kind, direction) > 0 ? cosine_density(context, kind, direction) : 0;
}

// What is lost: reflections below the horizon.
static void shares_check(const Counted *counted, uint32_t launches)
{
  for (int kind = LOBES; kind < CLASSES; kind++) {
    Histogram above = {0};
    double samples = samples_of(kind, launches), expected = 0, got = 0;
    histogram_expect(&above, lobe_density, NULL, kind, up_of(kind), samples * counted->to_specular[kind]);
    for (int cell = 0; cell < HISTOGRAM_CELLS; cell++) {
      expected += above.expected[cell];
      got += counted->lobes[kind].got[cell];
    }
    if (!(fabs(got - expected) < 4.5 * sqrt(expected)))
      fail_msg("roughness %g: %g reflected, not %g", roughness_of(kind), got, expected);
  }
}

static void directions_check(uint32_t lanes, uint32_t launches)
{
  Scene scene = surfaces_scene();
  ShadeLab lab = surfaces_lab(&scene, lanes);
  Counted *counted = oracle_array(1, sizeof *counted);
  for (uint32_t launch = 0; launch < launches; launch++) {
    ShadeInfo info = launch_info(launch);
    lab_shade(NULL, &lab, &info);
    lobes_count(counted, &lab);
    environment_rays_count(counted, &lab);
  }
  print_message("LANES %u:\n", lanes);
  ImageDensity image = image_density_make(&scene.environment);
  for (int kind = FACES_UP; kind <= FACES_DOWN; kind++) {
    histogram_expect(&counted->image[kind], image_density, &image, kind, up_of(kind), samples_of(kind, launches));
    histogram_check("by the image", kind, &counted->image[kind]);
  }
  histogram_expect(&counted->cosine, seen_cosine_density, &image, IS_MIRROR, up_of(IS_MIRROR),
                   samples_of(IS_MIRROR, launches));
  histogram_check("by the cosine", IS_MIRROR, &counted->cosine);
  for (int kind = LOBES; kind < CLASSES; kind++) {
    histogram_expect(&counted->lobes[kind], lobe_density, NULL, kind, up_of(kind),
                     samples_of(kind, launches) * counted->to_specular[kind]);
    histogram_check("by the lobe", kind, &counted->lobes[kind]);
  }
  shares_check(counted, launches);
  free(counted);
  lab_close(&lab);
  scene_free(&scene);
}

static void few_pixels_check(uint32_t width, uint32_t height)
{
  enum { FEW_LAUNCHES = 64 };
  Scene scene = surfaces_scene();
  free(scene.environment.image.pixels);
  small_picture_set(&scene, width, height);
  ShadeLab lab = surfaces_lab(&scene, 16);
  Counted *counted = oracle_array(1, sizeof *counted);
  for (uint32_t launch = 0; launch < FEW_LAUNCHES; launch++) {
    ShadeInfo info = launch_info(launch);
    lab_shade(NULL, &lab, &info);
    environment_rays_count(counted, &lab);
  }
  ImageDensity image = image_density_make(&scene.environment);
  for (int kind = FACES_UP; kind <= FACES_DOWN; kind++) {
    histogram_expect(&counted->image[kind], image_density, &image, kind, up_of(kind), samples_of(kind, FEW_LAUNCHES));
    histogram_check("by few pixels", kind, &counted->image[kind]);
  }
  free(counted);
  lab_close(&lab);
  scene_free(&scene);
}

static void an_image_may_be_of_few_pixels(void **state)
{
  few_pixels_check(1, 1);
  few_pixels_check(3, 2);
  few_pixels_check(1, 5);
}

static void directions_have_the_densities_that_are_said(void **state)
{
  directions_check(16, LAUNCHES);
  directions_check(8, LAUNCHES / 4);
  directions_check(1, LAUNCHES / 4);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(directions_have_the_densities_that_are_said),
      cmocka_unit_test(an_image_may_be_of_few_pixels),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}

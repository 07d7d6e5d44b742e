// Camera visibility as tests drive it: a scene on a device, its hits by rays and by each way and width of raster.
#pragma once

#include "passes/raster_visibility.h"
#include "passes/trace.h"
#include "support/soup.h"

// Every way that can run on a CPU device; the last is what GPUs run, work-groups and all.
typedef enum RasterVariant {
  RASTER_BINS_16,
  RASTER_BINS_8,
  RASTER_BINS_1,
  RASTER_DIRECT_1,
  RASTER_VARIANTS
} RasterVariant;
extern const char *const raster_variant_names[RASTER_VARIANTS];

// Variants that this device's compiler gets right: all of them, or all but the last, and says so.
int raster_variant_count(void);

// For cmocka's group set-up and tear-down: those of gltf_build.h, and a CPU device.
int raster_tests_begin(void **state);
int raster_tests_end(void **state);

// The device, made one of the variant's width until the next call.
Device *raster_device(RasterVariant variant);

// Fails the test with the log's message.
extern Log raster_log;
void raster_assert_ok(Status status);

// A scene on the device. Failures of these functions fail the test.
typedef struct RasterFixture {
  DeviceScene scene;
  RasterScene triangles;
  Tracer tracer;
  RasterVisibility rasters[RASTER_VARIANTS];  // made when first used
} RasterFixture;
void raster_fixture_make(RasterFixture *out, const Scene *scene);
void raster_fixture_of_soup(RasterFixture *out, Soup *soup);  // and frees the soup
void raster_fixture_free(RasterFixture *fixture);

// What is looked at: `wave_tiles` tiles of one sample at a time (0: all).
enum { SHOT_VIEWS_MOST = 6 };
typedef struct RasterShot {
  Camera camera;
  PictureArea area;
  uint32_t samples, wave_tiles;
  CameraInfo views[SHOT_VIEWS_MOST];  // in place of the camera where there are any
  uint32_t view_count;
  uint32_t hidden[2];  // ids of triangles that are not there, [first, end); raster alone
} RasterShot;
RasterShot raster_shot(const Camera *camera, uint32_t width, uint32_t height, uint32_t samples);

// Hits of all slots, sample by sample, tile by tile.
typedef struct RasterHits {
  uint32_t count;
  float *t, *u, *v;
  uint32_t *ids;  // HIT_NONE for none
} RasterHits;
RasterHits raster_hits_by_rays(RasterFixture *fixture, const RasterShot *shot);
// `options` may be NULL for the usual.
RasterHits raster_hits(RasterFixture *fixture, const RasterShot *shot, RasterVariant variant,
                       const RasterOptions *options);
void raster_hits_free(RasterHits *hits);

// Pixel of a slot of the whole picture's first sample: the order of shared/stream.h, by counting.
void raster_slot_pixel(uint32_t *x, uint32_t *y, uint32_t slot, uint32_t width, uint32_t height);

// Slots that hit something.
uint32_t raster_hits_count(const RasterHits *hits);

// Slots that differ in a bit; prints the first few.
uint32_t raster_hits_differ(const RasterHits *a, const RasterHits *b, const char *what);

// Fails unless rays and every variant give the same bits; returns the hits by rays.
RasterHits raster_assert_same(RasterFixture *fixture, const RasterShot *shot, const char *what);

// Checks one view of a soup, at 1 and 4 samples, and frees the soup. Returns how many samples hit at 1.
uint32_t raster_check_soup(const char *what, Soup *soup, const Camera *camera, uint32_t width, uint32_t height);

// A camera that sees all from near its eye on.
Camera raster_camera(Vec3 eye, Vec3 target, double yfov_rad);

// What light maps know for sure, as GPUs draw it, is what CPUs draw, at every width.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "device_scene/solid.h"
#include "passes/sure_maps.h"
#include "scene/scene_defaults.h"
#include "support/gltf_build.h"
#include "support/raster_fixture.h"
#include "support/scene_features.h"
#include "support/test_device.h"

// A light's maps, on the host.
typedef struct SureCopy {
  uint32_t block_count, tile_count;
  ShadowTile *tiles;
  ShadowBlock *blocks;
  ShadowRow *rows;
} SureCopy;

static void *buffer_copy(Device *device, const DeviceBuffer *buffer)
{
  void *to = malloc(buffer->bytes);
  assert_non_null(to);
  raster_assert_ok(buffer_read(device, buffer, to, buffer->bytes, &raster_log));
  return to;
}

// Marks every third tile; `close` is about how close the scene is to the light.
static void tiles_mark(SureMaps *maps, Device *device, float close)
{
  size_t count = maps->marks.bytes / sizeof(uint32_t);
  uint32_t *marks = malloc(count * sizeof *marks);
  assert_non_null(marks);
  for (size_t i = 0; i < count; i++) {
    float least = close * (0.5f + 0.1f * (float)(i % 10));
    uint32_t bits;
    memcpy(&bits, &least, sizeof bits);
    marks[i] = i % 3 ? SHADOW_TILE_UNKNOWN : bits >> 31 ? ~bits : bits | 0x80000000u;
  }
  raster_assert_ok(buffer_write(device, &maps->marks, marks, maps->marks.bytes, &raster_log));
  free(marks);
}

static SureCopy maps_draw(RasterFixture *fixture, const Solids *solids, const ShadowFit *fit, RasterVariant variant,
                          uint32_t pass_chunks, float close)
{
  Device *device = raster_device(variant);
  SureRaster raster;
  SureMaps maps = {0};
  DeviceBuffer solid;
  RasterOptions options = {.way = variant == RASTER_DIRECT_1 ? RASTER_WAY_DIRECT : RASTER_WAY_BINS,
                           .pass_chunks = pass_chunks};
  raster_assert_ok(
      buffer_create(&solid, device, solids->word_count * sizeof *solids->bits, solids->bits, "solid", &raster_log));
  raster_assert_ok(sure_raster_make(&raster, device, &fixture->triangles, &options, &raster_log));
  raster_assert_ok(sure_maps_aim(&maps, device, fit, 1, isfinite(close), &raster_log));
  if (isfinite(close)) {
    tiles_mark(&maps, device, close);
    raster_assert_ok(sure_maps_read_marks(&maps, device, &raster_log));
  }
  raster_assert_ok(sure_maps_settle(&maps, device, NULL, NULL, &raster_log));
  raster_assert_ok(
      sure_maps_draw(&maps, 0, &raster, device, &fixture->triangles, &solid, SURE_MARKED_SOLID, &raster_log));
  SureCopy copy = {maps.block_count, maps.tile_count, buffer_copy(device, &maps.tiles),
                   buffer_copy(device, &maps.blocks), buffer_copy(device, &maps.rows)};
  assert_int_equal(maps.block_count, SHADOW_TILE_BLOCKS * maps.known_tiles[0]);
  sure_maps_free(&maps);
  sure_raster_free(&raster);
  buffer_free(&solid);
  return copy;
}

static void copy_free(SureCopy *copy)
{
  free(copy->tiles);
  free(copy->blocks);
  free(copy->rows);
}

// Entry k of a texel's list: false where there is none, or what it says means nothing.
static bool entry_of(float *near, uint32_t *number, const SureCopy *copy, uint32_t block, uint32_t texel, uint32_t k,
                     float least)
{
  const ShadowBlock *of = &copy->blocks[block];
  const ShadowRow *row = k ? &copy->rows[(size_t)(k - 1) * copy->block_count + block] : &of->first;
  if (k >= of->row_count || !(row->near[texel] > -INFINITY) || row->near[texel] < of->covered[texel]) return false;
  if (row->near[texel] < least) return false;
  *near = row->near[texel];
  *number = row->number[texel];
  return true;
}

// Of a texel in block `block` of a and `of` of b: in what is closer than `least`.
static bool texels_differ(const SureCopy *a, const SureCopy *b, uint32_t block, uint32_t of, uint32_t texel,
                          float least)
{
  const ShadowBlock *of_a = &a->blocks[block], *of_b = &b->blocks[of];
  float covered_a = fmaxf(of_a->covered[texel], least), covered_b = fmaxf(of_b->covered[texel], least);
  if (memcmp(&covered_a, &covered_b, sizeof covered_a) != 0) return true;
  float rest_a = fmaxf(of_a->rest[texel], covered_a), rest_b = fmaxf(of_b->rest[texel], covered_b);
  if (memcmp(&rest_a, &rest_b, sizeof rest_a) != 0) return true;
  for (uint32_t k = 0; k < SHADOW_NUMBERS; k++) {
    float near[2] = {0};
    uint32_t number[2] = {0};
    bool has_a = entry_of(&near[0], &number[0], a, block, texel, k, least),
         has_b = entry_of(&near[1], &number[1], b, of, texel, k, least);
    if (has_a != has_b || memcmp(&near[0], &near[1], sizeof(float)) != 0 || number[0] != number[1]) return true;
  }
  return false;
}

// Whether something is in the tile of a block. Where nothing is, a block may not be written.
static bool block_is_drawn(const SureCopy *copy, uint32_t block)
{
  return copy->tiles[block / SHADOW_TILE_BLOCKS].near > -INFINITY;
}

// Fails unless all variants draw the same of each light's maps, and something. The first draws the scene in one pass.
static void scene_check(const Scene *scene, const Camera *camera, uint32_t size_px, uint32_t pass_chunks)
{
  RasterFixture fixture;
  Solids solids;
  const PictureArea area = {160, 90, 0, 0, 160, 90};
  const CameraInfo info = camera_info(camera, &area);
  raster_fixture_make(&fixture, scene);
  raster_assert_ok(solids_make(&solids, scene, &raster_log));
  const ShadowScope scope = {&info, fixture.scene.low, fixture.scene.high};
  const ShadowOptions shadow_options = {.map_size_px = size_px};
  assert_true(fixture.scene.light_count > 0);
  for (uint32_t light = 0; light < fixture.scene.light_count; light++) {
    ShadowFit fit;
    uint32_t named = 0, covered = 0, full = 0;
    if (!shadow_fit(&fit, &fixture.scene.light_infos[light], SHADOWS_HYBRID, &shadow_options, &scope)) continue;
    SureCopy copies[RASTER_VARIANTS];
    for (int v = 0; v < raster_variant_count(); v++)
      copies[v] = maps_draw(&fixture, &solids, &fit, (RasterVariant)v, v == RASTER_BINS_16 ? 0 : pass_chunks, INFINITY);
    for (int v = 1; v < raster_variant_count(); v++)
      assert_memory_equal(copies[0].tiles, copies[v].tiles, copies[0].tile_count * sizeof(ShadowTile));
    for (uint32_t i = 0; i < 16 * copies[0].block_count; i++) {
      if (!block_is_drawn(&copies[0], i / 16)) continue;
      const ShadowBlock *block = &copies[0].blocks[i / 16];
      for (int v = 1; v < raster_variant_count(); v++)
        if (texels_differ(&copies[0], &copies[v], i / 16, i / 16, i % 16, -INFINITY))
          fail_msg("light %u, texel %u of block %u: %s differs", light, i % 16, i / 16, raster_variant_names[v]);
      named += block->first.near[i % 16] > -INFINITY;
      covered += block->covered[i % 16] > -INFINITY;
      full += block->rest[i % 16] > -INFINITY;
    }
    printf("light %u: of %u texels %u name triangles, %u not all, %u are covered\n", light, 16 * copies[0].block_count,
           named, full, covered);
    assert_true(named > 0 && covered > 0);
    for (int v = 0; v < raster_variant_count(); v++) copy_free(&copies[v]);
  }
  solids_free(&solids);
  raster_fixture_free(&fixture);
}

// Every kind of material and light; sizes that are not of whole tiles or bins.
static void every_way_and_width_knows_the_same(void **state)
{
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  scene_check(&scene, &camera, 20, 0);
  scene_check(&scene, &camera, 100, 0);
  scene_free(&scene);
}

// The same where some of it casts no shadow.
static void every_way_leaves_out_the_same(void **state)
{
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  for (uint32_t i = 0; i < scene.object_count; i += 3) scene.objects[i].shadowless = true;
  scene_check(&scene, &camera, 36, 0);
  scene_free(&scene);
}

// Lists that overflow, in bins that several passes add to.
static void passes_add_up_to_the_whole(void **state)
{
  Scene scene = gltf_read_fine("scenes/colonnade.glb");
  Camera camera;
  raster_assert_ok(scene_camera_choose(&camera, &scene, NULL, 16.0 / 9, &raster_log));
  scene_check(&scene, &camera, 64, 96);
  scene_free(&scene);
}

// Of a map of which some tiles are marked these alone are drawn, and of them what is as close as is asked: as in the
// whole map.
static void marked_tiles_know_what_the_whole_map_knows(void **state)
{
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  RasterFixture fixture;
  Solids solids;
  const PictureArea area = {160, 90, 0, 0, 160, 90};
  const CameraInfo info = camera_info(&camera, &area);
  raster_fixture_make(&fixture, &scene);
  raster_assert_ok(solids_make(&solids, &scene, &raster_log));
  const ShadowScope scope = {&info, fixture.scene.low, fixture.scene.high};
  const ShadowOptions shadow_options = {.map_size_px = 100};
  uint32_t drawn = 0, dropped = 0;
  for (uint32_t light = 0; light < fixture.scene.light_count; light++) {
    ShadowFit fit;
    if (!shadow_fit(&fit, &fixture.scene.light_infos[light], SHADOWS_HYBRID, &shadow_options, &scope)) continue;
    float close = fit.views[0].raster.parallel ? -0.8f : 0.25f;
    SureCopy whole = maps_draw(&fixture, &solids, &fit, RASTER_BINS_16, 0, INFINITY);
    for (int v = 0; v < raster_variant_count(); v++) {
      SureCopy marked = maps_draw(&fixture, &solids, &fit, (RasterVariant)v, 0, close);
      assert_int_equal(whole.tile_count, marked.tile_count);
      for (uint32_t t = 0; t < marked.tile_count; t++) {
        const ShadowTile *tile = &marked.tiles[t], *all = &whole.tiles[t];
        assert_int_equal(tile->first_block == SHADOW_TILE_UNKNOWN, t % 3 != 0);
        if (tile->first_block == SHADOW_TILE_UNKNOWN) continue;
        assert_true(tile->near <= all->near && tile->covered <= all->covered);
        if (!(tile->near > -INFINITY)) {
          dropped += all->near > -INFINITY;
          assert_true(all->near < tile->least);
          continue;
        }
        drawn++;
        for (uint32_t i = 0; i < 16 * SHADOW_TILE_BLOCKS; i++)
          if (texels_differ(&whole, &marked, all->first_block + i / 16, tile->first_block + i / 16, i % 16,
                            tile->least))
            fail_msg("light %u, texel %u of tile %u: %s differs", light, i, t, raster_variant_names[v]);
      }
      copy_free(&marked);
    }
    copy_free(&whole);
  }
  printf("%u tiles drawn, %u hold nothing close enough\n", drawn, dropped);
  assert_true(drawn > 100 && dropped > 10);
  solids_free(&solids);
  raster_fixture_free(&fixture);
  scene_free(&scene);
}

// Maps made smaller by 2 and by 4 are marked where the finer ones were, by the least close of their marks.
static void smaller_maps_are_marked_alike(void **state)
{
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  RasterFixture fixture;
  const PictureArea area = {160, 90, 0, 0, 160, 90};
  const CameraInfo info = camera_info(&camera, &area);
  raster_fixture_make(&fixture, &scene);
  const ShadowScope scope = {&info, fixture.scene.low, fixture.scene.high};
  Device *device = raster_device(RASTER_BINS_16);
  for (uint8_t level = 1; level <= 2; level++) {
    SureMaps maps = {0};
    ShadowFit fit, smaller;
    const LightInfo *light = &fixture.scene.light_infos[0];
    assert_true(shadow_fit(&fit, light, SHADOWS_HYBRID, &(ShadowOptions){.map_size_px = 256}, &scope));
    assert_true(shadow_fit(&smaller, light, SHADOWS_HYBRID, &(ShadowOptions){.map_size_px = 256 >> level}, &scope));
    raster_assert_ok(sure_maps_aim(&maps, device, &fit, 1, true, &raster_log));
    tiles_mark(&maps, device, 0.25f);
    raster_assert_ok(sure_maps_read_marks(&maps, device, &raster_log));
    for (uint32_t i = 0; i < maps.tile_count; i++)
      if (i % (level == 1 ? 5 : 21)) maps.seen[i] = SHADOW_TILE_UNKNOWN;
    const uint32_t columns = 16, fewer = columns >> level, marked = sure_maps_marked(&maps, 0, level);
    uint32_t *fine = malloc(maps.tile_count * sizeof *fine), known = 0;
    assert_non_null(fine);
    memcpy(fine, maps.seen, maps.tile_count * sizeof *fine);
    raster_assert_ok(sure_maps_shrink(&maps, device, &smaller, &level, &raster_log));
    assert_int_equal(maps.tile_count, fit.info.view_count * fewer * fewer);
    for (uint32_t i = 0; i < maps.tile_count; i++) {
      uint32_t view = i / (fewer * fewer), y = i / fewer % fewer << level, x = i % fewer << level;
      uint32_t least = SHADOW_TILE_UNKNOWN;
      for (uint32_t k = 0; k < 1u << 2 * level; k++) {
        uint32_t at = (view * columns + y + (k >> level)) * columns + x + k % (1u << level);
        least = fine[at] < least ? fine[at] : least;
      }
      assert_int_equal(maps.seen[i], least);
      known += least != SHADOW_TILE_UNKNOWN;
    }
    assert_int_equal(known, marked);
    assert_in_range(known, 1, maps.tile_count - 1);
    raster_assert_ok(sure_maps_settle(&maps, device, NULL, NULL, &raster_log));
    assert_int_equal(maps.known_tiles[0], known);
    free(fine);
    sure_maps_free(&maps);
  }
  raster_fixture_free(&fixture);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_way_and_width_knows_the_same),
      cmocka_unit_test(every_way_leaves_out_the_same),
      cmocka_unit_test(passes_add_up_to_the_whole),
      cmocka_unit_test(marked_tiles_know_what_the_whole_map_knows),
      cmocka_unit_test(smaller_maps_are_marked_alike),
  };
  return cmocka_run_group_tests(tests, raster_tests_begin, raster_tests_end);
}

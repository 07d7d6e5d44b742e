// Room for sure maps, and what of it is filled by those of the frame before.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/movers.h"
#include "passes/sure_maps.h"

// What cl/rays/shadow_mark.cl made a mark of.
static float least_of(uint32_t mark)
{
  float least;
  uint32_t bits = mark >> 31 ? mark & 0x7fffffffu : ~mark;
  memcpy(&least, &bits, sizeof least);
  return least;
}

static uint32_t view_tiles(const ShadowInfo *info) { return TILE_COLUMNS(info->size_px) * TILE_COLUMNS(info->size_px); }

// Tiles as they are before anything is drawn, and the blocks of each view.
static void tiles_fill(SureMaps *maps, ShadowTile *tiles)
{
  const uint32_t *marks = maps->seen;
  maps->block_count = 0;
  for (uint32_t light = 0; light < maps->light_count; light++) {
    const ShadowInfo *info = &maps->lights[light];
    const uint32_t blocks_before = maps->block_count;
    for (uint32_t view = 0, i = info->first_texel; view < info->view_count; view++) {
      SureBlocks *blocks = &maps->view_blocks[light][view];
      blocks->first = maps->block_count;
      for (const uint32_t end = i + view_tiles(info); i < end; i++) {
        bool known = !marks || marks[i] != SHADOW_TILE_UNKNOWN;
        tiles[i] = (ShadowTile){known ? maps->block_count : SHADOW_TILE_UNKNOWN,
                                marks && known ? least_of(marks[i]) : -INFINITY, -INFINITY, -INFINITY};
        if (known) maps->block_count += SHADOW_TILE_BLOCKS;
      }
      blocks->count = maps->block_count - blocks->first;
    }
    maps->known_tiles[light] = (maps->block_count - blocks_before) / SHADOW_TILE_BLOCKS;
  }
}

static bool view_stayed(const SureMaps *maps, const SureMaps *before, uint32_t light, uint32_t view,
                        const DeviceScene *scene)
{
  if (!maps->seen || !before->seen || light >= before->light_count) return false;
  ShadowInfo a = maps->lights[light], b = before->lights[light];
  const ShadowView *now = maps->view_table + a.first_view + view, *then = before->view_table + b.first_view + view;
  const uint32_t *seen = maps->seen + a.first_texel, *seen_before = before->seen + b.first_texel;
  const size_t tiles = view_tiles(&a);
  a.first_view = b.first_view = a.first_texel = b.first_texel = 0;
  return memcmp(&a, &b, sizeof a) == 0 && memcmp(now, then, sizeof *now) == 0 &&
         memcmp(seen + view * tiles, seen_before + view * tiles, tiles * sizeof *seen) == 0 &&
         !moved_casters_seen(scene, &now->raster);
}

// Says of all views whether they stayed; false where none did.
static bool views_compare(SureMaps *maps, const SureMaps *before, const DeviceScene *scene)
{
  bool any = false;
  for (uint32_t light = 0; light < maps->light_count; light++)
    for (uint32_t view = 0; view < maps->lights[light].view_count; view++)
      any |= maps->stayed[light][view] = view_stayed(maps, before, light, view, scene);
  return any;
}

// The tiles of views that stayed, as they were drawn; says whether all that is behind them lies where it lay.
static void tiles_take(ShadowTile *tiles, bool *in_place, const SureMaps *maps, const SureMaps *before,
                       const ShadowTile *tiles_before)
{
  *in_place = maps->block_count == before->block_count;
  for (uint32_t light = 0; light < maps->light_count; light++) {
    const ShadowInfo *info = &maps->lights[light];
    const uint32_t count = view_tiles(info);
    for (uint32_t view = 0; view < info->view_count; view++) {
      if (!maps->stayed[light][view]) continue;
      const uint32_t shift = maps->view_blocks[light][view].first - before->view_blocks[light][view].first;
      *in_place &= shift == 0;
      for (uint32_t i = view * count; i < (view + 1) * count; i++) {
        ShadowTile tile = tiles_before[before->lights[light].first_texel + i];
        if (tile.first_block != SHADOW_TILE_UNKNOWN) tile.first_block += shift;
        tiles[info->first_texel + i] = tile;
      }
    }
  }
}

static Status blocks_copy(const SureMaps *maps, const SureMaps *before, Device *device, uint32_t light, uint32_t view,
                          Log *log)
{
  Status status = STATUS_OK;
  const size_t block = sizeof(ShadowBlock) / sizeof(uint32_t), row = sizeof(ShadowRow) / sizeof(uint32_t);
  const size_t from = before->view_blocks[light][view].first, to = maps->view_blocks[light][view].first,
               count = maps->view_blocks[light][view].count;
  TRY(buffer_copy_words(device, &before->blocks, from * block, &maps->blocks, to * block, count * block, log));
  for (size_t k = 0; k < SHADOW_NUMBERS - 1; k++)
    TRY(buffer_copy_words(device, &before->rows, (k * before->block_count + from) * row, &maps->rows,
                          (k * maps->block_count + to) * row, count * row, log));

done:
  return status;
}

static Status blocks_make(SureMaps *maps, Device *device, SureMaps *before, bool in_place, Log *log)
{
  Status status = STATUS_OK;
  const size_t blocks = maps->block_count;
  if (in_place) {
    maps->blocks = before->blocks;
    maps->rows = before->rows;
    before->blocks = before->rows = (DeviceBuffer){0};
    return STATUS_OK;
  }
  TRY(buffer_create(&maps->blocks, device, blocks * sizeof(ShadowBlock), NULL, "sure maps", log));
  TRY(buffer_create(&maps->rows, device, (SHADOW_NUMBERS - 1) * blocks * sizeof(ShadowRow), NULL, "sure maps", log));
  for (uint32_t light = 0; light < maps->light_count; light++)
    for (uint32_t view = 0; view < maps->lights[light].view_count; view++)
      if (maps->stayed[light][view] && maps->view_blocks[light][view].count)
        TRY(blocks_copy(maps, before, device, light, view, log));

done:
  return status;
}

void sure_maps_stay(SureMaps *maps)
{
  for (uint32_t light = 0; light < maps->light_count; light++)
    for (uint32_t view = 0; view < maps->lights[light].view_count; view++) maps->stayed[light][view] = true;
}

Status sure_maps_settle(SureMaps *maps, Device *device, const DeviceScene *scene, SureMaps *before, Log *log)
{
  Status status = STATUS_OK;
  const size_t count = maps->tile_count;
  bool in_place = false;
  ShadowTile *tiles = malloc((count + 1) * sizeof *tiles), *tiles_before = NULL;
  if (!tiles) return log_no_memory(log, "sure maps");
  tiles_fill(maps, tiles);
  if (before && views_compare(maps, before, scene)) {
    tiles_before = malloc((before->tile_count + 1ull) * sizeof *tiles_before);
    if (!tiles_before) {
      status = log_no_memory(log, "sure maps");
      goto done;
    }
    TRY(buffer_read(device, &before->tiles, tiles_before, before->tile_count * sizeof *tiles_before, log));
    tiles_take(tiles, &in_place, maps, before, tiles_before);
  }
  TRY(buffer_create(&maps->tiles, device, count * sizeof *tiles, tiles, "sure maps", log));
  TRY(blocks_make(maps, device, before, in_place, log));

done:
  free(tiles);
  free(tiles_before);
  return status;
}

// Raster of camera visibility, one work-item a bin and sample: which triangle does each sample's ray meet first?
//
//   in    cameras, offsets     as the ray generator takes them
//         records, spans, starts, lists   triangles by bin (visibility_setup.cl); bins of rows [first_row, first_row +
//         rows) of each view
//   out   hits, hit_ids        the hit stream of the wave (shared/stream.h): the bits that trace_closest gives
//
//   Cost  about 20 ns a triangle and bin, less where few blocks hide it, 12 ns a triangle and block of 4 x 4 pixels
//   that it may meet, 20 ns a block; 16 bytes a slot. A triangle is tried on blocks, not on pixels: LANES samples at
//   once are handed to triangle_edges, which decides. Its blocks are listed first: the end of one loop over them is
//   foreseen more often than the ends of one for each row, which took a seventh of the time. Chunks come nearest first;
//   a block is not tried where all of it is nearer than the triangle can be met. Work-items of bin rows [wave_row,
//   wave_row + wave_rows); blocks outside the wave are left alone. With `begin` the slots start empty, without it what
//   is there is improved on: a scene of several passes. A work-item has 120 KiB of memory of its own.

#include "lib/bin_samples.cl"
#include "lib/bins.cl"

// A triangle with its components in the order kx, ky, kz of one dominant axis.
typedef struct Permuted {
  float a[3], b[3], c[3];
} Permuted;

static inline Permuted triangle_permute(uint number, uint axis, const Target *from)
{
  global const RasterBlock *block = &from->triangles[number / RASTER_STEP];
  uint slot = number % RASTER_STEP, kx = axis == 2 ? 0 : axis + 1, ky = axis == 0 ? 2 : axis - 1;
  float x = from->origin[kx], y = from->origin[ky], z = from->origin[axis];
  Permuted p = {{block->vertex[0][kx][slot] - x, block->vertex[0][ky][slot] - y, block->vertex[0][axis][slot] - z},
                {block->vertex[1][kx][slot] - x, block->vertex[1][ky][slot] - y, block->vertex[1][axis][slot] - z},
                {block->vertex[2][kx][slot] - x, block->vertex[2][ky][slot] - y, block->vertex[2][axis][slot] - z}};
  return p;
}

// Asks for the vertices and the id of the triangle of a record.
static inline void triangle_prefetch(global const uint *record, const Target *from)
{
  uint number = record[VISIBLE_NUMBER];
  global const uint *lines = (global const uint *)&from->triangles[number / RASTER_STEP] + number % RASTER_STEP;
#pragma unroll
  for (uint line = 0; line < 10; line++) PREFETCH(lines + line * RASTER_STEP);
}

// Holds a doubtful hit of a triangle on part of a block within the triangle's box.
static __attribute__((noinline)) void samples_hold(TriangleHit *hit, uint number, const BinSamples *bin, uint block,
                                                   uint part, const Target *to)
{
  IntL lane = INTL((int)(part * LANES)) + LANE_INDEX;
  UintL x = UINTL(bin->px.x + block % BIN_SIDE * 4) + LANE_AS_UINT(lane & INTL(3));
  UintL y = UINTL(bin->px.y + block / BIN_SIDE * 4) + LANE_AS_UINT(lane >> INTL(2));
  CameraRay ray = camera_ray(bin->camera, x, y, bin->offset);
  const SlabAxis slab[3] = {slab_axis(ray.origin.x, ray.direction.x), slab_axis(ray.origin.y, ray.direction.y),
                            slab_axis(ray.origin.z, ray.direction.z)};
  global const RasterBlock *triangles = &to->triangles[number / RASTER_STEP];
  FloatL vertex[3][3];
#pragma unroll
  for (uint corner = 0; corner < 3; corner++)
#pragma unroll
    for (uint axis = 0; axis < 3; axis++)
      vertex[corner][axis] = FLOATL(triangles->vertex[corner][axis][number % RASTER_STEP]);
  hit_hold(hit, FLOATL(to->t_min), slab, vertex[0], vertex[1], vertex[2]);
}

// Tries a triangle on the lanes of `lanes` of part of a block.
static inline __attribute__((always_inline)) void samples_test(const Permuted *p, global const uint *record,
                                                               const ShearedRay *ray, IntL lanes, BinSamples *bin,
                                                               uint block, uint part, Target *to)
{
  Block *samples = &bin->blocks[block];
  uint number = record[VISIBLE_NUMBER], flags = record[VISIBLE_FLAGS];
  to->tests++;
  TriangleEdges edges =
      triangle_edges(ray, FLOATL(p->a[0]), FLOATL(p->a[1]), FLOATL(p->a[2]), FLOATL(p->b[0]), FLOATL(p->b[1]),
                     FLOATL(p->b[2]), FLOATL(p->c[0]), FLOATL(p->c[1]), FLOATL(p->c[2]));
  if (!any_lane(edges.inside)) return;
  TriangleHit hit = triangle_distance(&edges, ray);
  uint id = to->triangles[number / RASTER_STEP].id[number % RASTER_STEP];
  FloatL t = samples->t[part];
  UintL ids = samples->ids[part];
  IntL positive_kz = ray->shear_z > FLOATL(0);
  IntL wins = hit_is_closest(&hit, lanes, FLOATL(to->t_min), t, ids, id, flags, positive_kz);
  if (!any_lane(wins)) return;
  triangle_complete(&hit, &edges, ray);
  if (any_lane(wins & (hit.doubtful | !(hit.t < FLOATL(INFINITY))))) {
    TriangleHit held = hit;  // a copy, so that the usual hit stays in registers
    samples_hold(&held, number, bin, block, part, to);
    hit = held;
    wins = hit_is_closest(&hit, lanes, FLOATL(to->t_min), t, ids, id, flags, positive_kz) & (hit.t > hit.t_error);
  }
  wins = hit_passes(&hit, wins, id, flags, to->attributes);
  to->covered += (uint)popcount(lane_bits(wins));
  samples->t[part] = wins ? hit.t : t;
  samples->ids[part] = wins ? UINTL(id) : ids;
  samples->u[part] = wins ? hit.u : samples->u[part];
  samples->v[part] = wins ? hit.v : samples->v[part];
  bin->changed[block / BIN_SIDE] |= 1u << block % BIN_SIDE;
}

// A block of any kind of rays: those of parallel projection, and those that do not share their dominant axis.
static __attribute__((noinline)) void block_test_any(global const uint *record, BinSamples *bin, uint block, Target *to)
{
  for (uint part = 0; part < BLOCK_PARTS; part++) {
    const Block *samples = &bin->blocks[block];
    Vec3L kept = vec3l(samples->a[part], samples->b[part], samples->c[part]);
    Vec3L direction = bin->is_parallel ? bin->parallel : kept, origin = bin->is_parallel ? kept : no_origin();
    bool sheared = !bin->is_parallel && bin->axis[block] != AXIS_MIXED;
    UintL axis = sheared ? UINTL(bin->axis[block]) : dominant_axis(direction);
    for (uint kz = 0; kz < 3; kz++) {
      IntL lanes = axis == UINTL(kz);
      if (!any_lane(lanes)) continue;
      Permuted p = triangle_permute(record[VISIBLE_NUMBER], kz, to);
      ShearedRay ray = {origin.x, origin.y, origin.z, kept.x, kept.y, kept.z};
      if (!sheared) ray = shear_ray(origin, direction, kz);
      samples_test(&p, record, &ray, lanes, bin, block, part, to);
    }
  }
}

// Tries one triangle on the blocks of the bin that it may meet.
static inline __attribute__((always_inline)) void bin_triangle(global const uint *record, BinSamples *bin,
                                                               float2 corner, Target *to)
{
  global const float *numbers = (global const float *)record;
  global const float *edge = numbers + VISIBLE_EDGE, *bounds = numbers + VISIBLE_BOUNDS;
  // In pixels from the bin's first sample.
  float low_x = bounds[0] - corner.x, low_y = bounds[1] - corner.y, high_x = bounds[2] - corner.x,
        high_y = bounds[3] - corner.y;
  if (!(low_x <= RASTER_BIN_PX - 1 && low_y <= RASTER_BIN_PX - 1 && high_x >= 0 && high_y >= 0)) return;
  uint first_row = low_y > 3 ? (uint)(low_y - 3) / 4 : 0,
       last_row = high_y < RASTER_BIN_PX ? (uint)high_y / 4 : BIN_SIDE - 1;
  bool shared = bin->shared_axis != AXIS_MIXED && !bin->is_parallel;
  Permuted p = triangle_permute(record[VISIBLE_NUMBER], shared ? bin->shared_axis : 0, to);
  float edge_y[3], base[3], near = numbers[VISIBLE_NEAR];
  FloatL along[3][BLOCK_PARTS];
  IntL beside[BLOCK_PARTS];
  for (uint part = 0; part < BLOCK_PARTS; part++) {
    FloatL x = LANE_CONVERT_FLOAT((INTL((int)(part * LANES)) + LANE_INDEX) * INTL(4));
    beside[part] = (x > FLOATL(high_x)) | (x + FLOATL(3) < FLOATL(low_x));
    for (uint i = 0; i < 3; i++) along[i][part] = FLOATL(edge[3 * i]) * x;
  }
  for (uint i = 0; i < 3; i++) {
    edge_y[i] = 4 * edge[3 * i + 1];
    base[i] = edge[3 * i + 2] + edge[3 * i] * corner.x + edge[3 * i + 1] * corner.y;
  }
  int blocks[BIN_BLOCKS + LANES];
  uint count = 0;
  for (uint row = first_row; row <= last_row; row++) {
    for (uint part = 0; part < BLOCK_PARTS; part++) {
      IntL out = beside[part] | (FLOATL(near) > bin->farthest[row][part]);
      out = out | (along[0][part] + FLOATL(base[0] + edge_y[0] * (float)row) < FLOATL(0));
      out = out | (along[1][part] + FLOATL(base[1] + edge_y[1] * (float)row) < FLOATL(0));
      out = out | (along[2][part] + FLOATL(base[2] + edge_y[2] * (float)row) < FLOATL(0));
      count = lanes_append(blocks, count, INTL((int)(row * BIN_SIDE + part * LANES)) + LANE_INDEX, !out);
    }
  }
  for (uint i = 0; i < count; i++) {
    uint block = (uint)blocks[i];
    if (!shared) {
      block_test_any(record, bin, block, to);
      continue;
    }
    const Block *samples = &bin->blocks[block];
    for (uint part = 0; part < BLOCK_PARTS; part++) {
      ShearedRay ray = {FLOATL(0), FLOATL(0), FLOATL(0), samples->a[part], samples->b[part], samples->c[part]};
      samples_test(&p, record, &ray, INTL(-1), bin, block, part, to);
    }
  }
}

// Numbers of those of a list's records that may be seen in the bin go to `kept`. Returns how many. In a scene of small
// triangles most lie behind all of the few blocks (2 x 2 at most) that they touch: that is told for LANES at once.
static inline uint records_choose(ushort *kept, global const uint *records, global const ushort *list, uint begin,
                                  uint end, const BinSamples *bin, float2 corner)
{
  const FloatL zero = FLOATL(0), last = FLOATL(RASTER_BIN_PX - 1), quarter = FLOATL(0.25f);
  const float *farthest = (const float *)bin->farthest;
  global const float *words = (global const float *)records;
  uint count = 0;
  for (bool is_short = end - begin < LANES; is_short && begin < end; begin++) {  // short lists are not worth it
    PREFETCH(words + list[begin] * VISIBLE_WORDS);
    kept[count++] = list[begin];
  }
  for (uint k = begin; k < min(begin + 2 * LANES, end); k++) PREFETCH(words + list[k] * VISIBLE_WORDS);
  for (uint k = begin; k < end; k += LANES) {
    for (uint j = k + 2 * LANES; j < min(k + 3 * LANES, end); j++) PREFETCH(words + list[j] * VISIBLE_WORDS);
    IntL there = LANE_INDEX < INTL((int)(end - k));
    UintL number = LANE_TYPE(convert_uint)(LANE_LOAD(list, k));
    UintL at = (there ? number : UINTL(list[k])) * UINTL(VISIBLE_WORDS);
    FloatL low_x = LANE_GATHER(FloatL, words, at + UINTL(VISIBLE_BOUNDS)) - FLOATL(corner.x);
    FloatL low_y = LANE_GATHER(FloatL, words, at + UINTL(VISIBLE_BOUNDS + 1)) - FLOATL(corner.y);
    FloatL high_x = LANE_GATHER(FloatL, words, at + UINTL(VISIBLE_BOUNDS + 2)) - FLOATL(corner.x);
    FloatL high_y = LANE_GATHER(FloatL, words, at + UINTL(VISIBLE_BOUNDS + 3)) - FLOATL(corner.y);
    FloatL near = LANE_GATHER(FloatL, words, at + UINTL(VISIBLE_NEAR));
    there = there & (low_x <= last) & (low_y <= last) & (high_x >= zero) & (high_y >= zero);
    IntL x0 = LANE_CONVERT_INT(ceil_lane(max_lane(low_x - FLOATL(3), zero) * quarter));
    IntL y0 = LANE_CONVERT_INT(ceil_lane(max_lane(low_y - FLOATL(3), zero) * quarter));
    IntL x1 = LANE_CONVERT_INT(min_lane(high_x, last) * quarter),
         y1 = LANE_CONVERT_INT(min_lane(high_y, last) * quarter);
    IntL few = there & (x1 - x0 <= INTL(1)) & (y1 - y0 <= INTL(1));
    IntL row0 = few ? y0 * INTL(BIN_SIDE) : INTL(0), row1 = few ? y1 * INTL(BIN_SIDE) : INTL(0);
    x0 = few ? x0 : INTL(0);
    x1 = few ? x1 : INTL(0);
    FloatL upper = max_lane(LANE_GATHER(FloatL, farthest, row0 + x0), LANE_GATHER(FloatL, farthest, row0 + x1));
    FloatL lower = max_lane(LANE_GATHER(FloatL, farthest, row1 + x0), LANE_GATHER(FloatL, farthest, row1 + x1));
    for (uint bits = lane_bits(there & !(few & (near > max_lane(upper, lower)))); bits; bits &= bits - 1)
      kept[count++] = list[k + lowest_bit(bits)];
  }
  return count;
}

// Draws a chunk's records of the bin's lists `in`.
static inline void chunk_draw(global const uint *records, global const ushort *lists, const BinLists *in,
                              BinSamples *bin, float2 corner, Target *to)
{
  ushort kept[RASTER_CHUNK];
  uint count = records_choose(kept, records, lists, in->begin[0], in->end[0], bin, corner);
  count += records_choose(kept + count, records, lists, in->begin[1], in->end[1], bin, corner);
  for (uint k = 0; k < count; k++) {
    triangle_prefetch(records + kept[min(k + PREFETCH_RECORDS / 2, count - 1)] * VISIBLE_WORDS, to);
    bin_triangle(records + kept[k] * VISIBLE_WORDS, bin, corner, to);
  }
}

// Adds to a sum of two words.
static inline void cost_add(global uint *sum, uint more)
{
  uint before = atomic_add(sum, more);
  if (before + more < before) atomic_inc(sum + 1);
}

kernel void visibility_bins(constant CameraInfo *cameras, uint view_count, constant Float2 *offsets, uint first_tile,
                            uint tile_count, uint first_sample, uint sample_count, uint columns, uint view_bins,
                            uint first_row, uint rows, uint first_bin, uint bin_count,
                            global const RasterBlock *triangles, global const uint *item_starts, uint first_item,
                            uint item_count, global const uint *records, global const uint *spans,
                            global const uint *starts, global const ushort *lists, uint begin, float t_min,
                            uint capacity, global float *hits, global uint *hit_ids, global uint *costs,
                            global const TriangleCorners *corners, global const Float2 *uvs,
                            global const Float4 *colors, uint vertex_count, global const MaterialInfo *materials,
                            global const TextureInfo *textures, global const uchar4 *texels,
                            constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint item = get_global_id(0), turn = item % bin_count, sample = item / bin_count, evens = (bin_count + 1) / 2;
  // A runtime gives a thread half of what is left: every other bin, not all of one side.
  uint number = first_bin + (turn < evens ? 2 * turn : 2 * (turn - evens) + 1);
  uint view = number / view_bins, bin_x = number % view_bins % columns, bin_y = number % view_bins / columns;
  constant CameraInfo *camera = &cameras[view];
  if (sample >= sample_count) return;
  Float2 offset = offsets[first_sample + sample];
  bool parallel = camera->orthographic;
  Float3 eye = camera->position;
  Target to = {(global FloatL *)(hits + HIT_T * capacity),
               (global FloatL *)(hits + HIT_U * capacity),
               (global FloatL *)(hits + HIT_V * capacity),
               (global UintL *)hit_ids,
               t_min,
               {parallel ? 0 : eye.x, parallel ? 0 : eye.y, parallel ? 0 : eye.z},
               triangles,
               &attributes,
               0,
               0};
  BinSamples bin;
  ulong keys[SORT_CHUNKS];
  uint2 bin_px = (uint2)(bin_x, bin_y) * (uint)RASTER_BIN_PX;
  float2 corner = (float2)((float)bin_px.x + offset.x, (float)bin_px.y + offset.y);
  uint2 items = view_items(item_starts, view, first_item, item_count);
  uint count = bin_chunks(keys, spans, item_count, items.x, min(items.x + SORT_CHUNKS, items.y), bin_x, bin_y);
  bool empty = begin && count == 0 && items.x + SORT_CHUNKS >= items.y;
  bin_make(&bin, camera, offset, bin_px, views_tiles(camera, view_count), view * camera_tiles(camera).y, first_tile,
           tile_count, sample, begin, empty, &to);
  if (empty) return;
  for (uint first = items.x; first < items.y; first += SORT_CHUNKS) {
    if (first > items.x)
      count = bin_chunks(keys, spans, item_count, first, min(first + SORT_CHUNKS, items.y), bin_x, bin_y);
    uint bins = columns * rows + 2;
    BinLists next = {{0, 0}, {0, 0}};
    if (count) next = bin_lists(spans, item_count, (uint)keys[0], starts + (uint)keys[0] * bins, bin_x, bin_y);
    for (uint i = 0; i < count; i++) {
      uint chunk = (uint)keys[i], later = (uint)keys[min(i + 1, count - 1)];
      BinLists in = next;
      next = bin_lists(spans, item_count, later, starts + later * bins, bin_x, bin_y);
      PREFETCH(lists + later * (RASTER_CHUNK * RASTER_LARGE_BINS) + next.begin[0]);
      PREFETCH(lists + later * (RASTER_CHUNK * RASTER_LARGE_BINS) + next.begin[1]);
      if (as_float(spans[SPAN_NEAR * item_count + chunk]) > bin_farthest(&bin)) continue;
      global const uint *from = records + chunk * (RASTER_CHUNK + 1) * VISIBLE_WORDS;
      global const ushort *numbers = lists + chunk * (RASTER_CHUNK * RASTER_LARGE_BINS);
      chunk_draw(from, numbers, &in, &bin, corner, &to);
    }
  }
  bin_store(&bin, &to);
  cost_add(costs + RASTER_COST_TESTS, to.tests / BLOCK_PARTS);
  cost_add(costs + RASTER_COST_COVERED, to.covered);
}

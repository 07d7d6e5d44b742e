// Raster of camera visibility, one work-item a bin and sample: which triangle does each sample's ray meet first?
//
//   in    camera, offsets      as the ray generator takes them
//         records, spans, starts, lists   triangles by bin (visibility_setup.cl); bins of rows [first_row, first_row +
//         rows)
//   out   hits, hit_ids        the hit stream of the wave (shared/stream.h): the bits that trace_closest gives
//
//   Cost  a few ns a triangle and bin, about 8 ns a triangle and block of 4 x 4 pixels that it may meet; 16 bytes a
//   slot. A triangle is tried on blocks, not on pixels: LANES samples at once are handed to triangle_intersect, which
//   decides. Work-items of bin rows [wave_row, wave_row + wave_rows); blocks outside the wave are left alone. With
//   `begin` the slots start empty, without it what is there is improved on: a scene of several passes.

#include "lib/bins.cl"
#include "lib/camera_ray.cl"
#include "lib/hit.cl"

#define BIN_SIDE (RASTER_BIN_PX / 4)  // blocks along the side of a bin
#define BIN_BLOCKS (BIN_SIDE * BIN_SIDE)
#define BLOCK_PARTS (16 / LANES)

#define AXIS_MIXED 3

// The samples of a bin, blocks row by row. In perspective a, b, c are the shear of a block whose rays share their
// dominant axis, and the direction where they do not; in parallel projection they are the origin.
typedef struct BinSamples {
  FloatL a[BIN_BLOCKS * BLOCK_PARTS], b[BIN_BLOCKS * BLOCK_PARTS], c[BIN_BLOCKS * BLOCK_PARTS];
  uint target[BIN_BLOCKS];  // of the first part of each block
  uchar axis[BIN_BLOCKS];
  uint inside[BIN_SIDE];  // blocks of a row that belong to the wave, a bit each
  uint shared_axis;       // of all blocks, else AXIS_MIXED
  Vec3L parallel;         // the direction of all rays in parallel projection
  bool is_parallel;
  constant CameraInfo *camera;
  Float2 offset;
  uint2 px;  // the bin's first pixel
} BinSamples;

// Hits by LANES slots: streams are aligned to whole vectors.
typedef struct Target {
  global FloatL *t, *u, *v;
  global UintL *ids;
  float t_min;
  global const RasterBlock *triangles;
  const AttributeSources *attributes;
  uint tests, covered;
} Target;

static inline void slots_empty(constant CameraInfo *camera, UintL x, UintL y, uint at, Target *to)
{
  to->t[at] = camera_ray_end(camera, x, y);
  to->u[at] = FLOATL(0);
  to->v[at] = FLOATL(0);
  to->ids[at] = UINTL(HIT_NONE);
}

static inline Vec3L no_origin(void) { return vec3l(FLOATL(0), FLOATL(0), FLOATL(0)); }

static inline void block_make(BinSamples *bin, uint block, constant CameraInfo *camera, Float2 offset, uint tile,
                              uint within, bool begin, Target *to)
{
  for (uint part = 0; part < BLOCK_PARTS; part++) {
    UintL x, y;
    tile_pixels(&x, &y, tile, within + part * LANES, camera->tiles_per_row);
    CameraRay ray = camera_ray(camera, x, y, offset);
    Vec3L kept = bin->is_parallel ? ray.origin : ray.direction;
    UintL axis = dominant_axis(ray.direction);
    uint kz = LANE_UINT(axis, 0), at = block * BLOCK_PARTS + part;
    bool shared = !any_lane(axis != UINTL(kz)) && (part == 0 || kz == bin->axis[block]);
    bin->axis[block] = shared ? kz : AXIS_MIXED;
    bin->a[at] = kept.x;
    bin->b[at] = kept.y;
    bin->c[at] = kept.z;
    if (begin) slots_empty(camera, x, y, bin->target[block] + part, to);
  }
  for (uint part = 0; part < BLOCK_PARTS && !bin->is_parallel && bin->axis[block] != AXIS_MIXED; part++) {
    uint at = block * BLOCK_PARTS + part;
    ShearedRay ray = shear_ray(no_origin(), vec3l(bin->a[at], bin->b[at], bin->c[at]), bin->axis[block]);
    bin->a[at] = ray.shear_x;
    bin->b[at] = ray.shear_y;
    bin->c[at] = ray.shear_z;
  }
}

static inline void bin_make(BinSamples *bin, constant CameraInfo *camera, Float2 offset, uint2 bin_px, uint first_tile,
                            uint tile_count, uint sample, bool begin, Target *to)
{
  bool any = false;
  bin->camera = camera;
  bin->offset = offset;
  bin->px = bin_px;
  bin->is_parallel = camera->orthographic;
  bin->parallel = broadcast3(camera->forward);
  bin->shared_axis = AXIS_MIXED;
  for (uint row = 0; row < BIN_SIDE; row++) {
    bin->inside[row] = 0;
    for (uint column = 0; column < BIN_SIDE; column++) {
      uint block = row * BIN_SIDE + column;
      uint2 px = bin_px + (uint2)(column, row) * 4u, tile_at = px / (uint)TILE_SIZE;
      uint tile = tile_at.y * camera->tiles_per_row + tile_at.x, within = (row & 1) * 32 + (column & 1) * 16;
      if (tile_at.x >= camera->tiles_per_row || tile < first_tile || tile >= first_tile + tile_count) continue;
      bin->inside[row] |= 1u << column;
      bin->target[block] = ((tile - first_tile + sample * tile_count) * TILE_PIXELS + within) / LANES;
      block_make(bin, block, camera, offset, tile, within, begin, to);
      bin->shared_axis = !any || bin->axis[block] == bin->shared_axis ? bin->axis[block] : AXIS_MIXED;
      any = true;
    }
  }
}

// A triangle with its components in the order kx, ky, kz of one dominant axis.
typedef struct Permuted {
  float a[3], b[3], c[3];
} Permuted;

static inline Permuted triangle_permute(global const float *vertex, uint axis)
{
  uint kx = axis == 2 ? 0 : axis + 1, ky = axis == 0 ? 2 : axis - 1;
  Permuted p = {{vertex[kx], vertex[ky], vertex[axis]},
                {vertex[3 + kx], vertex[3 + ky], vertex[3 + axis]},
                {vertex[6 + kx], vertex[6 + ky], vertex[6 + axis]}};
  return p;
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
  for (uint corner = 0; corner < 3; corner++)
    for (uint axis = 0; axis < 3; axis++)
      vertex[corner][axis] = FLOATL(triangles->vertex[corner][axis][number % RASTER_STEP]);
  hit_hold(hit, FLOATL(to->t_min), slab, vertex[0], vertex[1], vertex[2]);
}

// Tries a triangle on the lanes of `lanes` of part of a block.
static inline __attribute__((always_inline)) void samples_test(const Permuted *p, global const uint *record,
                                                               const ShearedRay *ray, IntL lanes, const BinSamples *bin,
                                                               uint block, uint part, Target *to)
{
  uint id = record[VISIBLE_ID], flags = record[VISIBLE_FLAGS], at = bin->target[block] + part;
  to->tests++;
  TriangleHit hit =
      triangle_intersect(ray, FLOATL(p->a[0]), FLOATL(p->a[1]), FLOATL(p->a[2]), FLOATL(p->b[0]), FLOATL(p->b[1]),
                         FLOATL(p->b[2]), FLOATL(p->c[0]), FLOATL(p->c[1]), FLOATL(p->c[2]));
  if (!any_lane(hit.inside)) return;
  FloatL t = to->t[at];
  UintL ids = to->ids[at];
  IntL positive_kz = ray->shear_z > FLOATL(0);
  IntL wins = hit_is_closest(&hit, lanes, FLOATL(to->t_min), t, ids, id, flags, positive_kz);
  if (!any_lane(wins)) return;
  if (any_lane(wins & hit.doubtful)) {
    TriangleHit held = hit;  // a copy, so that the usual hit stays in registers
    samples_hold(&held, record[VISIBLE_NUMBER], bin, block, part, to);
    hit = held;
    wins = hit_is_closest(&hit, lanes, FLOATL(to->t_min), t, ids, id, flags, positive_kz);
  }
  wins = hit_counts(&hit, wins, id, flags, to->attributes);
  if (!any_lane(wins)) return;
  to->covered += (uint)popcount(lane_bits(wins));
  to->t[at] = wins ? hit.t : t;
  to->ids[at] = wins ? UINTL(id) : ids;
  to->u[at] = wins ? hit.u : to->u[at];
  to->v[at] = wins ? hit.v : to->v[at];
}

// A block of any kind of rays: those of parallel projection, and those that do not share their dominant axis.
static __attribute__((noinline)) void block_test_any(global const uint *record, const BinSamples *bin, uint block,
                                                     Target *to)
{
  for (uint part = 0; part < BLOCK_PARTS; part++) {
    uint at = block * BLOCK_PARTS + part;
    Vec3L kept = vec3l(bin->a[at], bin->b[at], bin->c[at]);
    Vec3L direction = bin->is_parallel ? bin->parallel : kept, origin = bin->is_parallel ? kept : no_origin();
    bool sheared = !bin->is_parallel && bin->axis[block] != AXIS_MIXED;
    UintL axis = sheared ? UINTL(bin->axis[block]) : dominant_axis(direction);
    for (uint kz = 0; kz < 3; kz++) {
      IntL lanes = axis == UINTL(kz);
      if (!any_lane(lanes)) continue;
      Permuted p = triangle_permute((global const float *)record + VISIBLE_VERTEX, kz);
      ShearedRay ray = {origin.x, origin.y, origin.z, kept.x, kept.y, kept.z};
      if (!sheared) ray = shear_ray(origin, direction, kz);
      samples_test(&p, record, &ray, lanes, bin, block, part, to);
    }
  }
}

// Tries one triangle on the blocks of the bin that it may meet.
static inline __attribute__((always_inline)) void bin_triangle(global const uint *record, const BinSamples *bin,
                                                               float2 corner, Target *to)
{
  global const float *numbers = (global const float *)record, *vertex = numbers + VISIBLE_VERTEX;
  global const float *edge = numbers + VISIBLE_EDGE, *bounds = numbers + VISIBLE_BOUNDS;
  // In pixels from the bin's first sample.
  float low_x = bounds[0] - corner.x, low_y = bounds[1] - corner.y, high_x = bounds[2] - corner.x,
        high_y = bounds[3] - corner.y;
  if (!(low_x <= RASTER_BIN_PX - 1 && low_y <= RASTER_BIN_PX - 1 && high_x >= 0 && high_y >= 0)) return;
  uint first_row = low_y > 3 ? (uint)(low_y - 3) / 4 : 0,
       last_row = high_y < RASTER_BIN_PX ? (uint)high_y / 4 : BIN_SIDE - 1;
  bool shared = bin->shared_axis != AXIS_MIXED && !bin->is_parallel;
  Permuted p = triangle_permute(vertex, shared ? bin->shared_axis : 0);
  float edge_y[3], base[3];
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
  for (uint row = first_row; row <= last_row; row++) {
    uint blocks = 0;
    for (uint part = 0; part < BLOCK_PARTS; part++) {
      IntL out = beside[part];
      out = out | (along[0][part] + FLOATL(base[0] + edge_y[0] * (float)row) < FLOATL(0));
      out = out | (along[1][part] + FLOATL(base[1] + edge_y[1] * (float)row) < FLOATL(0));
      out = out | (along[2][part] + FLOATL(base[2] + edge_y[2] * (float)row) < FLOATL(0));
      blocks |= lane_bits(!out) << part * LANES;
    }
    for (blocks &= bin->inside[row]; blocks; blocks &= blocks - 1) {
      uint block = row * BIN_SIDE + lowest_bit(blocks);
      if (!shared) {
        block_test_any(record, bin, block, to);
        continue;
      }
      for (uint part = 0; part < BLOCK_PARTS; part++) {
        uint at = block * BLOCK_PARTS + part;
        ShearedRay ray = {FLOATL(0), FLOATL(0), FLOATL(0), bin->a[at], bin->b[at], bin->c[at]};
        samples_test(&p, record, &ray, INTL(-1), bin, block, part, to);
      }
    }
  }
}

// Adds to a sum of two words.
static inline void cost_add(global uint *sum, uint more)
{
  uint before = atomic_add(sum, more);
  if (before + more < before) atomic_inc(sum + 1);
}

kernel void visibility_bins(constant CameraInfo *camera, constant Float2 *offsets, uint first_tile, uint tile_count,
                            uint first_sample, uint sample_count, uint columns, uint first_row, uint rows,
                            uint wave_row, uint wave_rows, global const RasterBlock *triangles, uint chunk_count,
                            global const uint *records, global const RasterSpan *spans, global const uint *starts,
                            global const ushort *lists, uint begin, float t_min, uint capacity, global float *hits,
                            global uint *hit_ids, global uint *costs, global const TriangleCorners *corners,
                            global const Float2 *uvs, global const Float4 *colors, uint vertex_count,
                            global const MaterialInfo *materials, global const TextureInfo *textures,
                            global const uchar4 *texels, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  Bins bins = {columns, first_row, rows};
  uint item = get_global_id(0), bin_x = item % columns, bin_y = item / columns % wave_rows + wave_row;
  uint sample = item / columns / wave_rows;
  if (sample >= sample_count) return;
  Float2 offset = offsets[first_sample + sample];
  Target to = {(global FloatL *)(hits + HIT_T * capacity),
               (global FloatL *)(hits + HIT_U * capacity),
               (global FloatL *)(hits + HIT_V * capacity),
               (global UintL *)hit_ids,
               t_min,
               triangles,
               &attributes,
               0,
               0};
  BinSamples bin;
  uint2 bin_px = (uint2)(bin_x, bin_y) * (uint)RASTER_BIN_PX;
  bin_make(&bin, camera, offset, bin_px, first_tile, tile_count, sample, begin, &to);
  float2 corner = (float2)((float)bin_px.x + offset.x, (float)bin_px.y + offset.y);
  uint list = (bin_y - first_row) * columns + bin_x;
  for (uint chunk = 0; chunk < chunk_count; chunk++) {
    RasterSpan span = spans[chunk];
    if (bin_x < span.first_x || bin_x >= span.end_x || bin_y < span.first_y || bin_y >= span.end_y) continue;
    global const uint *from = records + chunk * (RASTER_CHUNK + 1) * VISIBLE_WORDS;
    global const uint *start = starts + chunk * (bins_count(bins) + 2);
    global const ushort *numbers = lists + chunk * (RASTER_CHUNK * RASTER_LARGE_BINS);
    for (uint i = start[list]; i < start[list + 1]; i++)
      bin_triangle(from + numbers[i] * VISIBLE_WORDS, &bin, corner, &to);
    for (uint i = start[bins_count(bins)]; i < start[bins_count(bins) + 1]; i++)
      bin_triangle(from + numbers[i] * VISIBLE_WORDS, &bin, corner, &to);
  }
  cost_add(costs + RASTER_COST_TESTS, to.tests / BLOCK_PARTS);
  cost_add(costs + RASTER_COST_COVERED, to.covered);
}

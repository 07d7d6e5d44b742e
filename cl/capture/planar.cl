// Flat mirrors: what a mirrored camera sees through the mirror, sample for sample, is what it reflects.
//
// The camera is mirrored at the plane and its picture turned left for right, so that it stays a camera like others:
// pixel x of the picture is pixel width - 1 - x of what it draws, width in whole tiles, and samples are turned with it.
//
//   planar_clip     triangles of the scene without those that lie behind the plane or in it. Those that cross it are
//                   drawn whole: what they hide wrongly is found out by planar_reflect
//   planar_keep     the ids that a wave of the mirrored camera found: names [sample][tile][TILE_PIXELS]
//   planar_reflect  reflected rays of mirrors in the plane: the exact hit of the ray itself on the triangle that its
//                   sample names, with the bits that trace_closest gives; none where that sees nothing. A ray is left
//                   to be traced that does not meet that triangle, or whose sample names one that is not opaque, or
//                   that is not where the mirrored camera looks; with `others` those of mirrors without a plane as well
//
//   Cost  raster of the scene once more for each plane, and a triangle test a ray; 4 bytes a sample of the picture.
//   Exact but for rounding at the edges of what hides what, which here are those of a camera and not of the ray.
//   From  Kilgard, "Improving Shadows and Reflections via the Stencil Buffer", 1999 (the mirrored camera).

#include "lib/named_hit.cl"
#include "lib/object.cl"
#include "lib/tile.cl"
#include "shared/cube.h"
#include "shared/planar.h"
#include "shared/raster.h"

static inline float plane_height(constant PlanarInfo *plane, float3 p)
{
  return plane->normal.x * p.x + plane->normal.y * p.y + plane->normal.z * p.z - plane->offset_m;
}

kernel void planar_clip(constant PlanarInfo *plane, global const RasterBlock *blocks, uint block_count,
                        global RasterBlock *out)
{
  uint i = get_global_id(0);
  if (i >= block_count) return;
  for (uint slot = 0; slot < RASTER_STEP; slot++) {
    bool before = false;
    for (uint corner = 0; corner < 3; corner++) {
      float p[3];
      for (uint axis = 0; axis < 3; axis++)
        out[i].vertex[corner][axis][slot] = p[axis] = blocks[i].vertex[corner][axis][slot];
      before |= plane_height(plane, (float3)(p[0], p[1], p[2])) > plane->slack_m;
    }
    out[i].id[slot] = before ? blocks[i].id[slot] : RASTER_UNUSED;
    out[i].flags[slot] = blocks[i].flags[slot];
  }
}

kernel void planar_keep(uint first_tile, uint tile_count, uint first_sample, uint ray_count, uint tiles,
                        global const uint *ids, global uint *names)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint slot = begin; slot < end; slot++) {
    uint tile = slot / TILE_PIXELS, sample = first_sample + tile / tile_count;
    names[((size_t)sample * tiles + first_tile + tile % tile_count) * TILE_PIXELS + slot % TILE_PIXELS] =
        min(ids[slot], CUBE_NAMELESS);
  }
}

// Where a slot of a wave of the picture is among the names.
static inline size_t name_place(constant PlanarInfo *plane, uint slot, uint first_tile, uint tile_count,
                                uint first_sample)
{
  uint2 grid = (uint2)(plane->tiles_per_row, plane->tile_rows);
  uint tile = slot / TILE_PIXELS, sample = first_sample + tile / tile_count;
  uint2 pixel = tile_pixel(first_tile + tile % tile_count, slot % TILE_PIXELS, grid);
  pixel.x = grid.x * TILE_SIZE - 1 - pixel.x;
  uint turned = tile_number(pixel / (uint)TILE_SIZE, grid);
  return ((size_t)sample * grid.x * grid.y + turned) * TILE_PIXELS +
         tile_slot(pixel.x % TILE_SIZE, pixel.y % TILE_SIZE);
}

// Does the mirrored camera look along the ray, on the mirror?
static inline bool is_seen(constant PlanarInfo *plane, float3 origin, float3 direction)
{
  float3 axis = plane->parallel ? (float3)(plane->forward.x, plane->forward.y, plane->forward.z)
                                : origin - (float3)(plane->eye.x, plane->eye.y, plane->eye.z);
  float3 aside = cross(axis, direction);
  return fabs(plane_height(plane, origin)) <= plane->slack_m && dot(axis, direction) > 0 &&
         dot(aside, aside) <= 1e-8f * dot(axis, axis) * dot(direction, direction);
}

// The triangles of the scene, by id.
typedef struct MeshSources {
  global const float *positions;  // [vertex_count][3]
  global const TriangleCorners *corners;
  global const MaterialInfo *materials;
} MeshSources;

// The hit of a ray on one triangle. The id is HIT_NONE where it does not meet it for sure.
static inline NamedHit hit_on(uint id, const MeshSources *from, float3 origin, float3 direction)
{
  NamedHit hit = {INFINITY, 0, 0, HIT_NONE};
  NamedTriangles one = named_none();
  NamedRay ray = named_ray(origin, direction);
  TriangleCorners corners = from->corners[id];
  uint flags = from->materials[corners.material].flags;
  float unclear_t = INFINITY;
  named_add(&one, &ray, vload3(corners.vertex[0], from->positions), vload3(corners.vertex[1], from->positions),
            vload3(corners.vertex[2], from->positions), id, flags & MATERIAL_SINGLE_SIDED,
            flags & (MATERIAL_MASKED | MATERIAL_BLENDED));
  named_test(&hit, &unclear_t, &ray, &one);
  return hit;
}

kernel void planar_reflect(constant PlanarInfo *plane, uint number, uint others, uint first_tile, uint tile_count,
                           uint first_sample, global const uint *names, global const float *rays,
                           global const uint *slots, uint capacity, uint ray_count, global const uint *object_starts,
                           uint object_count, global const uint *plane_of_object, global const float *positions,
                           global const TriangleCorners *corners, global const MaterialInfo *materials,
                           global float *left_rays, global uint *left_slots, global float *known_rays,
                           global uint *known_slots, global float *known_hits, global uint *known_ids,
                           global uint *counts)
{
  const MeshSources from = {positions, corners, materials};
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint i = begin; i < end; i++) {
    uint source = as_uint(rays[RAY_DENSITY * capacity + i]), own = PLANE_NONE;
    bool mirrored = source & RAY_FROM_MIRROR;
    if (mirrored) own = plane_of_object[object_of_triangle(object_starts, object_count, source & ~RAY_FROM_MIRROR)];
    if (own == PLANE_NONE ? !others : own != number) continue;
    NamedHit hit = {INFINITY, 0, 0, HIT_NONE};
    bool is_open = false;
    if (own == number) {
      float3 origin = (float3)(rays[RAY_ORIGIN_X * capacity + i], rays[RAY_ORIGIN_Y * capacity + i],
                               rays[RAY_ORIGIN_Z * capacity + i]);
      float3 direction = (float3)(rays[RAY_DIRECTION_X * capacity + i], rays[RAY_DIRECTION_Y * capacity + i],
                                  rays[RAY_DIRECTION_Z * capacity + i]);
      uint id = names[name_place(plane, slots[i], first_tile, tile_count, first_sample)];
      if (is_seen(plane, origin, direction)) {
        is_open = id == CUBE_NAMELESS;
        if (!is_open) hit = hit_on(id, &from, origin, direction);
      }
    }
    if (is_open || hit.id != HIT_NONE) {
      named_append(&hit, rays, slots, capacity, i, known_rays, known_slots, known_hits, known_ids, &counts[1]);
      continue;
    }
    uint at = ray_append(rays, slots, capacity, i, left_rays, left_slots, &counts[0]);
    if (!mirrored) left_rays[RAY_DENSITY * capacity + at] = as_float(source);
  }
}

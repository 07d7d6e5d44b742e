// Deterministic triangle soups and meshes for the tests of builders and kernels.
#pragma once

#include "accel/bvh.h"

// Numbers from a seed, the same everywhere. Source: O'Neill, "PCG: A Family of Simple Fast Space-Efficient
// Statistically Good Algorithms for Random Number Generation", 2014 (PCG-XSH-RR 64/32).
typedef struct Random {
  uint64_t state;
} Random;

Random random_make(uint64_t seed);
uint32_t random_next(Random *random);
float random_between(Random *random, float low, float high);  // [low, high]

typedef struct Soup {
  float (*positions)[3];
  uint32_t (*triangles)[3];
  uint32_t *flags;  // 0 unless a test sets them
  uint32_t vertex_count, triangle_count;
  uint32_t vertex_capacity, triangle_capacity;
} Soup;

// The generators add to `soup`, which starts as {0}; they end the program where memory runs out.

// Views the soup's arrays, until it grows or is freed.
TriangleSoup soup_view(const Soup *soup);
void soup_free(Soup *soup);

uint32_t soup_vertex(Soup *soup, float x, float y, float z);
void soup_triangle(Soup *soup, uint32_t a, uint32_t b, uint32_t c);

// Triangles with corners within `size` of a point anywhere in the cube [-half, half]^3.
void soup_random(Soup *soup, uint32_t count, float half, float size, uint64_t seed);

// Closed, welded sphere of `rows` x 2 `rows` cells, 4 rows (rows - 1) triangles that face outwards. `bumps` displaces
// the vertices along their radius by up to that share of it.
void soup_sphere(Soup *soup, uint32_t rows, float radius, const float center[3], float bumps);

// Closed, welded box of 12 cells^2 triangles that face outwards.
void soup_grid(Soup *soup, uint32_t cells, const float low[3], const float high[3]);

// Triangles of aspect 10^2 to 10^8 in the cube [-1, 1]^3; every eighth has no area.
void soup_slivers(Soup *soup, uint32_t count, uint64_t seed);

// Small triangles near the unit cube, all of it moved by 1e5 along each axis.
void soup_far(Soup *soup, uint32_t count, uint64_t seed);

// Axis-aligned rectangles of two triangles each that overlap in the plane z = `z`, with corners at quarters.
void soup_coplanar(Soup *soup, uint32_t rectangles, float z, uint64_t seed);

// Planes x, y and z = 0 .. cells, each cut into unit squares: vertices, edges and planes at integer coordinates.
void soup_axis(Soup *soup, uint32_t cells);

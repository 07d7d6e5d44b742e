#include "support/soup.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

Random random_make(uint64_t seed)
{
  Random random = {0};
  random_next(&random);
  random.state += seed;
  random_next(&random);
  return random;
}

uint32_t random_next(Random *random)
{
  uint64_t old = random->state;
  random->state = old * 6364136223846793005u + 1442695040888963407u;
  uint32_t shifted = (uint32_t)((old >> 18 ^ old) >> 27), turn = (uint32_t)(old >> 59);
  return shifted >> turn | shifted << (-turn & 31);
}

float random_between(Random *random, float low, float high)
{
  return low + (high - low) * (float)(random_next(random) >> 8) / 16777215.0f;
}

static void *grown(void *array, uint32_t capacity, size_t element_bytes)
{
  void *larger = realloc(array, capacity * element_bytes);
  if (larger) return larger;
  fprintf(stderr, "soup: out of memory\n");
  abort();
}

uint32_t soup_vertex(Soup *soup, float x, float y, float z)
{
  if (soup->vertex_count == soup->vertex_capacity) {
    soup->vertex_capacity = soup->vertex_capacity ? 2 * soup->vertex_capacity : 64;
    soup->positions = grown(soup->positions, soup->vertex_capacity, sizeof *soup->positions);
  }
  float *position = soup->positions[soup->vertex_count];
  position[0] = x;
  position[1] = y;
  position[2] = z;
  return soup->vertex_count++;
}

void soup_triangle(Soup *soup, uint32_t a, uint32_t b, uint32_t c)
{
  if (soup->triangle_count == soup->triangle_capacity) {
    soup->triangle_capacity = soup->triangle_capacity ? 2 * soup->triangle_capacity : 64;
    soup->triangles = grown(soup->triangles, soup->triangle_capacity, sizeof *soup->triangles);
    soup->flags = grown(soup->flags, soup->triangle_capacity, sizeof *soup->flags);
  }
  uint32_t *triangle = soup->triangles[soup->triangle_count];
  triangle[0] = a;
  triangle[1] = b;
  triangle[2] = c;
  soup->flags[soup->triangle_count++] = 0;
}

// The quad a, b, c, d as two triangles; a side without length gives none.
static void soup_quad(Soup *soup, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
  if (a != b && b != c) soup_triangle(soup, a, b, c);
  if (c != d && d != a) soup_triangle(soup, a, c, d);
}

TriangleSoup soup_view(const Soup *soup)
{
  return (TriangleSoup){.positions = (const float(*)[3])soup->positions,
                        .triangles = (const uint32_t(*)[3])soup->triangles,
                        .flags = soup->flags,
                        .vertex_count = soup->vertex_count,
                        .triangle_count = soup->triangle_count};
}

void soup_free(Soup *soup)
{
  free(soup->positions);
  free(soup->triangles);
  free(soup->flags);
  *soup = (Soup){0};
}

static void soup_random_triangle(Soup *soup, Random *random, float middle, float half, float size)
{
  float center[3];
  uint32_t corner[3];
  for (int axis = 0; axis < 3; axis++) center[axis] = middle + random_between(random, -half, half);
  for (int i = 0; i < 3; i++) {
    float x = random_between(random, -size, size), y = random_between(random, -size, size);
    float z = random_between(random, -size, size);
    corner[i] = soup_vertex(soup, center[0] + x, center[1] + y, center[2] + z);
  }
  soup_triangle(soup, corner[0], corner[1], corner[2]);
}

void soup_random(Soup *soup, uint32_t count, float half, float size, uint64_t seed)
{
  Random random = random_make(seed);
  for (uint32_t i = 0; i < count; i++) soup_random_triangle(soup, &random, 0, half, size);
}

void soup_far(Soup *soup, uint32_t count, uint64_t seed)
{
  Random random = random_make(seed);
  for (uint32_t i = 0; i < count; i++) soup_random_triangle(soup, &random, 1e5f, 1, 0.1f);
}

void soup_sphere(Soup *soup, uint32_t rows, float radius, const float center[3], float bumps)
{
  const double pi = 3.14159265358979323846;
  uint32_t columns = 2 * rows;
  uint32_t top = soup_vertex(soup, center[0], center[1] + radius, center[2]);
  uint32_t first = soup->vertex_count;
  for (uint32_t row = 1; row < rows; row++) {
    double theta = pi * row / rows;
    for (uint32_t column = 0; column < columns; column++) {
      double phi = 2 * pi * column / columns;
      double r = radius * (1 - 0.5 * bumps * (1 + sin(17 * theta) * sin(11 * phi)));
      soup_vertex(soup, (float)(center[0] + r * sin(theta) * cos(phi)), (float)(center[1] + r * cos(theta)),
                  (float)(center[2] - r * sin(theta) * sin(phi)));
    }
  }
  uint32_t bottom = soup_vertex(soup, center[0], center[1] - radius, center[2]);
  for (uint32_t row = 0; row < rows; row++) {
    for (uint32_t column = 0; column < columns; column++) {
      uint32_t next = (column + 1) % columns, above = first + (row - 1) * columns, below = first + row * columns;
      uint32_t a = row == 0 ? top : above + column, d = row == 0 ? top : above + next;
      uint32_t b = row == rows - 1 ? bottom : below + column, c = row == rows - 1 ? bottom : below + next;
      soup_quad(soup, a, b, c, d);
    }
  }
}

// Index in 0 .. 6 cells^2 + 1 of a vertex on the surface of the lattice [0, cells]^3, as it is met in lattice order.
static uint32_t grid_surface_index(uint32_t cells, uint32_t x, uint32_t y, uint32_t z)
{
  uint32_t side = cells + 1, slab = side * side, ring = slab - (cells - 1) * (cells - 1);
  if (z == 0) return y * side + x;
  if (z == cells) return slab + (cells - 1) * ring + y * side + x;
  uint32_t before = slab + (z - 1) * ring;
  if (y == 0) return before + x;
  if (y == cells) return before + side + 2 * (cells - 1) + x;
  return before + side + 2 * (y - 1) + (x == cells);
}

void soup_grid(Soup *soup, uint32_t cells, const float low[3], const float high[3])
{
  uint32_t first = soup->vertex_count;
  for (uint32_t z = 0; z <= cells; z++)
    for (uint32_t y = 0; y <= cells; y++)
      for (uint32_t x = 0; x <= cells; x++) {
        uint32_t at[3] = {x, y, z};
        float position[3];
        int on_surface = 0;
        for (int axis = 0; axis < 3; axis++) {
          position[axis] = at[axis] == cells ? high[axis] : low[axis] + (high[axis] - low[axis]) * at[axis] / cells;
          on_surface |= at[axis] == 0 || at[axis] == cells;
        }
        if (on_surface) soup_vertex(soup, position[0], position[1], position[2]);
      }
  for (int face = 0; face < 6; face++) {
    int axis = face / 2, across = (axis + 1) % 3, along = (axis + 2) % 3, is_high = face % 2;
    for (uint32_t i = 0; i < cells; i++)
      for (uint32_t j = 0; j < cells; j++) {
        uint32_t corner[4];
        for (int k = 0; k < 4; k++) {
          uint32_t at[3];
          at[axis] = is_high ? cells : 0;
          at[across] = i + (k == 1 || k == 2);
          at[along] = j + (k >= 2);
          corner[k] = first + grid_surface_index(cells, at[0], at[1], at[2]);
        }
        if (is_high)
          soup_quad(soup, corner[0], corner[1], corner[2], corner[3]);
        else
          soup_quad(soup, corner[0], corner[3], corner[2], corner[1]);
      }
  }
}

void soup_slivers(Soup *soup, uint32_t count, uint64_t seed)
{
  Random random = random_make(seed);
  for (uint32_t i = 0; i < count; i++) {
    float from[3], to[3], aside[3];
    float width = i % 8 == 7 ? 0 : powf(10, random_between(&random, -8, -2));
    for (int axis = 0; axis < 3; axis++) {
      from[axis] = random_between(&random, -1, 1);
      to[axis] = random_between(&random, -1, 1);
      aside[axis] = from[axis] + width * random_between(&random, -1, 1);
    }
    uint32_t a = soup_vertex(soup, from[0], from[1], from[2]), b = soup_vertex(soup, to[0], to[1], to[2]);
    soup_triangle(soup, a, b, soup_vertex(soup, aside[0], aside[1], aside[2]));
  }
}

void soup_coplanar(Soup *soup, uint32_t rectangles, float z, uint64_t seed)
{
  Random random = random_make(seed);
  for (uint32_t i = 0; i < rectangles; i++) {
    float x = 0.25f * (random_next(&random) % 16), y = 0.25f * (random_next(&random) % 16);
    float right = x + 0.25f * (1 + random_next(&random) % 8), up = y + 0.25f * (1 + random_next(&random) % 8);
    uint32_t a = soup_vertex(soup, x, y, z), b = soup_vertex(soup, right, y, z);
    uint32_t c = soup_vertex(soup, right, up, z), d = soup_vertex(soup, x, up, z);
    soup_quad(soup, a, b, c, d);
  }
}

void soup_axis(Soup *soup, uint32_t cells)
{
  uint32_t first = soup->vertex_count, side = cells + 1, stride[3] = {1, side, side * side};
  for (uint32_t z = 0; z <= cells; z++)
    for (uint32_t y = 0; y <= cells; y++)
      for (uint32_t x = 0; x <= cells; x++) soup_vertex(soup, (float)x, (float)y, (float)z);
  for (int axis = 0; axis < 3; axis++) {
    uint32_t across = stride[(axis + 1) % 3], along = stride[(axis + 2) % 3];
    for (uint32_t plane = 0; plane <= cells; plane++)
      for (uint32_t i = 0; i < cells; i++)
        for (uint32_t j = 0; j < cells; j++) {
          uint32_t a = first + plane * stride[axis] + i * across + j * along;
          soup_quad(soup, a, a + across, a + across + along, a + along);
        }
  }
}

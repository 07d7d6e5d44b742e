#include "bench/raster_peer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void out_of_memory(void)
{
  fprintf(stderr, "bench_raster: out of memory\n");
  exit(1);
}

// Number of each vertex among those with positions of their own, whose numbers `firsts` gets. Returns how many.
static uint32_t vertices_weld(const FlatScene *flat, uint32_t *numbers, uint32_t *firsts)
{
  uint32_t count = 0, size = 4;
  while (size < 2 * flat->vertex_count) size *= 2;
  uint32_t *table = calloc(size, sizeof *table);
  if (!table) out_of_memory();
  for (uint32_t i = 0; i < flat->vertex_count; i++) {
    uint32_t words[3];
    memcpy(words, flat->positions[i], sizeof words);
    uint64_t hash = (words[0] * 0x9e3779b97f4a7c15u + words[1]) * 0x9e3779b97f4a7c15u + words[2];
    uint32_t at = (uint32_t)((hash * 0x9e3779b97f4a7c15u) >> 32) & (size - 1);
    while (table[at] && memcmp(flat->positions[firsts[table[at] - 1]], words, sizeof words)) at = (at + 1) & (size - 1);
    if (!table[at]) {
      firsts[count++] = i;
      table[at] = count;
    }
    numbers[i] = table[at] - 1;
  }
  free(table);
  return count;
}

uint32_t raster_peer_take(GlPeer *peer, const FlatScene *flat)
{
  uint32_t *numbers = calloc(flat->vertex_count, sizeof *numbers), *firsts = calloc(flat->vertex_count, sizeof *firsts);
  float(*positions)[3] = calloc(flat->vertex_count, sizeof *positions);
  float(*normals)[3] = calloc(flat->vertex_count, sizeof *normals);
  uint32_t(*triangles)[3] = calloc(flat->triangle_count, sizeof *triangles);
  if (!numbers || !firsts || !positions || !normals || !triangles) out_of_memory();
  uint32_t count = vertices_weld(flat, numbers, firsts);
  for (uint32_t i = 0; i < count; i++) {
    memcpy(positions[i], flat->positions[firsts[i]], sizeof positions[i]);
    memcpy(normals[i], flat->normals[firsts[i]], sizeof normals[i]);
  }
  for (uint32_t i = 0; i < flat->triangle_count; i++)
    for (int k = 0; k < 3; k++) triangles[i][k] = numbers[flat->corners[i].vertex[k]];
  gl_peer_scene(peer, positions, normals, count, triangles, flat->triangle_count);
  free(numbers);
  free(firsts);
  free(positions);
  free(normals);
  free(triangles);
  return count;
}

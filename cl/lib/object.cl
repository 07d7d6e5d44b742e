// Which object a triangle belongs to.

// Object whose triangles [starts[o], starts[o + 1]) hold `id`.
static inline uint object_of_triangle(global const uint *starts, uint object_count, uint id)
{
  uint low = 0, high = object_count;
  while (high - low > 1) {
    uint middle = (low + high) / 2;
    if (starts[middle] <= id)
      low = middle;
    else
      high = middle;
  }
  return low;
}

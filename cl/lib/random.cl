// Random numbers without a state: points of a scrambled low-discrepancy sequence, by key and sample. The same numbers
// in whatever order rays are worked through.
//
//   From  Jarzynski, Olano, "Hash Functions for GPU Rendering", JCGT 2020 (pcg); Burley, "Practical Hash-based Owen
//         Scrambling", JCGT 2020; Vegdahl, "Building a Better LK Hash", 2021 (the constants); Ahmed, "An
//         Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and Compact", EGSR 2024.

#include "lib/lanes.cl"

static inline UintL hash_pcg(UintL x)
{
  UintL state = x * UINTL(747796405u) + UINTL(2891336453u);
  UintL word = ((state >> ((state >> UINTL(28)) + UINTL(4))) ^ state) * UINTL(277803737u);
  return (word >> UINTL(22)) ^ word;
}

static inline UintL reverse_bits(UintL x)
{
  x = (x >> UINTL(16)) | (x << UINTL(16));
  x = ((x >> UINTL(8)) & UINTL(0x00ff00ffu)) | ((x & UINTL(0x00ff00ffu)) << UINTL(8));
  x = ((x >> UINTL(4)) & UINTL(0x0f0f0f0fu)) | ((x & UINTL(0x0f0f0f0fu)) << UINTL(4));
  x = ((x >> UINTL(2)) & UINTL(0x33333333u)) | ((x & UINTL(0x33333333u)) << UINTL(2));
  return ((x >> UINTL(1)) & UINTL(0x55555555u)) | ((x & UINTL(0x55555555u)) << UINTL(1));
}

// A permutation in which bit i depends on bits 0..i alone: an Owen scramble of the reversed number.
static inline UintL scramble_reversed(UintL x, UintL seed)
{
  x ^= x * UINTL(0x3d20adeau);
  x += seed;
  x *= (seed >> UINTL(16)) | UINTL(1);
  x ^= x * UINTL(0x05526c56u);
  return x ^ (x * UINTL(0x53a22864u));
}

// [0, 1) in steps of 2^-24.
static inline FloatL unit_from_bits(UintL bits)
{
  return LANE_CONVERT_FLOAT(bits >> UINTL(8)) * FLOATL(5.9604644775390625e-8f);
}

// Point `sample` of the Sobol (0, 2) sequence, its order and both coordinates scrambled by `key`: any 2^k points from a
// multiple of 2^k on are stratified in both coordinates and in all their products of powers of two.
static inline void random_point(UintL key, UintL sample, FloatL *x, FloatL *y)
{
  UintL seed = hash_pcg(key);
  UintL index = reverse_bits(scramble_reversed(reverse_bits(sample), seed));
  UintL second = index ^ (index >> UINTL(16));
  second ^= (second & UINTL(0xff00ff00u)) >> UINTL(8);
  second ^= (second & UINTL(0xf0f0f0f0u)) >> UINTL(4);
  second ^= (second & UINTL(0xccccccccu)) >> UINTL(2);
  second ^= (second & UINTL(0xaaaaaaaau)) >> UINTL(1);
  seed = hash_pcg(seed);
  *x = unit_from_bits(reverse_bits(scramble_reversed(index, seed)));
  *y = unit_from_bits(reverse_bits(scramble_reversed(second, hash_pcg(seed))));
}

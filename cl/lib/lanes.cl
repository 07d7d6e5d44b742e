// One source, two widths. A kernel handles LANES rays or pixels at once: an explicit vector on a CPU device, where the
// compiler's own vectoriser gives up on loops, and a scalar on a GPU, where a work-item is a lane.
//
// Comparisons of vectors give -1 or 0 a lane, of scalars 1 or 0: combine masks with & | ! and choose with `m ? a : b`,
// which work on both. `a < b ? a : b` is a minimum that ignores a NaN in a; fmin and fmax are slower on a CPU.

#pragma OPENCL FP_CONTRACT OFF

#define LANES_PASTE_(a, b) a##b
#define LANES_PASTE(a, b) LANES_PASTE_(a, b)

#if LANES == 1
#define LANE_TYPE(name) name
#define LANE_LOAD(pointer, index) ((pointer)[index])
#define LANE_STORE(value, pointer, index) ((pointer)[index] = (value))
#define LANE_INDEX 0
#else
#define LANE_TYPE(name) LANES_PASTE(name, LANES)
#define LANE_LOAD(pointer, index) LANES_PASTE(vload, LANES)(0, (pointer) + (index))
#define LANE_STORE(value, pointer, index) LANES_PASTE(vstore, LANES)(value, 0, (pointer) + (index))
#if LANES == 8
#define LANE_INDEX ((int8)(0, 1, 2, 3, 4, 5, 6, 7))
#else
#define LANE_INDEX ((int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15))
#endif
#endif

#ifdef __has_builtin
#if __has_builtin(__builtin_reduce_or)
#define HAS_REDUCTION
#endif
#if LANES > 1 && __has_builtin(__builtin_prefetch)
#define HAS_PREFETCH
#endif
#if LANES > 1 && defined(__SSE4_1__) && __has_builtin(__builtin_elementwise_floor) && \
    __has_builtin(__builtin_elementwise_ceil)
#define HAS_ROUNDING
#endif
#if LANES == 16 && defined(__AVX512DQ__) && __has_builtin(__builtin_ia32_cvtd2mask512)
#define HAS_MASK_REGISTERS
#endif
#if LANES == 16 && defined(__AVX512F__) && __has_builtin(__builtin_ia32_permvarsf512) && \
    __has_builtin(__builtin_ia32_vpermi2varps512) && __has_builtin(__builtin_ia32_compresssi512_mask)
#define HAS_PERMUTATION
#endif
#endif

typedef LANE_TYPE(float) FloatL;
typedef LANE_TYPE(int) IntL;
typedef LANE_TYPE(uint) UintL;

// One lane of a vector, as an lvalue.
#if LANES == 1
#define LANE_FLOAT(vector, lane) (vector)
#define LANE_UINT(vector, lane) (vector)
#define LANE_INT(vector, lane) (vector)
#else
#define LANE_FLOAT(vector, lane) (((float *)&(vector))[lane])
#define LANE_UINT(vector, lane) (((uint *)&(vector))[lane])
#define LANE_INT(vector, lane) (((int *)&(vector))[lane])
#endif

#define FLOATL(x) ((FloatL)(x))
#define UINTL(x) ((UintL)(x))
#define INTL(x) ((IntL)(x))
#define LANE_CONVERT_FLOAT(x) LANE_TYPE(convert_float)(x)
#define LANE_CONVERT_INT(x) LANE_TYPE(convert_int)(x)
#define LANE_AS_FLOAT(x) LANE_TYPE(as_float)(x)
#define LANE_AS_INT(x) LANE_TYPE(as_int)(x)
#define LANE_AS_UINT(x) LANE_TYPE(as_uint)(x)

// Whether a lane of the mask is set. any() of a vector becomes a branch a lane on PoCL; where the compiler keeps masks
// in registers of their own, asking for one costs nothing, else clang's own reduction is a few instructions, and
// without it a test of 64 bits does.
static inline bool any_lane(IntL mask)
{
#if LANES == 1
  return mask != 0;
#elif defined(HAS_MASK_REGISTERS)
  return (ushort)__builtin_ia32_cvtd2mask512(mask) != 0;
#elif defined(HAS_REDUCTION)
  return __builtin_reduce_or(mask) != 0;
#elif LANES == 16
  return as_ulong(convert_char8(mask.lo | mask.hi)) != 0;
#else
  return as_ulong(convert_char8(mask)) != 0;
#endif
}

#if LANES == 16
static inline bool any_of_16(int16 mask) { return any_lane(mask); }
#elif LANES == 8
static inline bool any_of_16(int16 mask) { return any_lane(mask.lo | mask.hi); }
#endif

// Bit i of the result: lane i of the mask.
static inline uint lane_bits(IntL mask)
{
#if LANES == 1
  return mask != 0;
#elif defined(HAS_MASK_REGISTERS)
  return (ushort)__builtin_ia32_cvtd2mask512(mask);
#else
  uint bits = 0;
#if LANES == 16
  ulong low = as_ulong(convert_char8(mask.lo)) & 0x8040201008040201ul;
  ulong high = as_ulong(convert_char8(mask.hi)) & 0x8040201008040201ul;
  bits = (uint)((low * 0x0101010101010101ul) >> 56) | (uint)((high * 0x0101010101010101ul) >> 56) << 8;
#else
  ulong low = as_ulong(convert_char8(mask)) & 0x8040201008040201ul;
  bits = (uint)((low * 0x0101010101010101ul) >> 56);
#endif
  return bits;
#endif
}

// Index of the lowest set bit.
static inline uint lowest_bit(uint bits) { return 31 - clz(bits & -bits); }

// Puts the lanes of `mask` behind the `count` values of a list, which has room for LANES more. Returns how many there
// are then.
static inline uint lanes_append(int *list, uint count, IntL values, IntL mask)
{
  uint bits = lane_bits(mask);
#ifdef HAS_PERMUTATION
  LANE_STORE(__builtin_ia32_compresssi512_mask(values, INTL(0), (ushort)bits), list, count);
  return count + (uint)popcount(bits);
#else
  for (; bits; bits &= bits - 1) list[count++] = LANE_INT(values, lowest_bit(bits));
  return count;
#endif
}

// Asks for the cache line of an address that will be read soon.
#ifdef HAS_PREFETCH
#define PREFETCH(pointer) __builtin_prefetch((const void *)(size_t)(pointer))
#else
#define PREFETCH(pointer)
#endif

// pointer[index] by lane; every lane's index must be valid.
#if LANES == 1
#define LANE_GATHER(type, pointer, index) ((pointer)[index])
#elif LANES == 8
#define LANE_GATHER(type, pointer, index)                                                             \
  ((type)((pointer)[(index).s0], (pointer)[(index).s1], (pointer)[(index).s2], (pointer)[(index).s3], \
          (pointer)[(index).s4], (pointer)[(index).s5], (pointer)[(index).s6], (pointer)[(index).s7]))
#else
#define LANE_GATHER(type, pointer, index)                                                             \
  ((type)((pointer)[(index).s0], (pointer)[(index).s1], (pointer)[(index).s2], (pointer)[(index).s3], \
          (pointer)[(index).s4], (pointer)[(index).s5], (pointer)[(index).s6], (pointer)[(index).s7], \
          (pointer)[(index).s8], (pointer)[(index).s9], (pointer)[(index).sa], (pointer)[(index).sb], \
          (pointer)[(index).sc], (pointer)[(index).sd], (pointer)[(index).se], (pointer)[(index).sf]))
#endif

// table[index] in the lanes of `mask`, `other` in the rest; the tables have 16 entries.
static inline FloatL table_pick(global const float *table, UintL index, IntL mask, FloatL other)
{
#ifdef HAS_PERMUTATION
  FloatL picked = __builtin_ia32_permvarsf512(vload16(0, table), LANE_AS_INT(index));
  return mask ? picked : other;
#else
  for (uint bits = lane_bits(mask); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    LANE_FLOAT(other, lane) = table[LANE_UINT(index, lane)];
  }
  return other;
#endif
}

static inline UintL table_pick_uint(global const uint *table, UintL index, IntL mask, UintL other)
{
  return LANE_AS_UINT(table_pick((global const float *)table, index, mask, LANE_AS_FLOAT(other)));
}

// One instruction on NVIDIA, which also ignores a NaN in b.
#if LANES == 1 && defined(__NV_CL_C_VERSION)
static inline FloatL min_lane(FloatL a, FloatL b) { return fmin(a, b); }
static inline FloatL max_lane(FloatL a, FloatL b) { return fmax(a, b); }
#else
static inline FloatL min_lane(FloatL a, FloatL b) { return a < b ? a : b; }
static inline FloatL max_lane(FloatL a, FloatL b) { return a > b ? a : b; }
#endif

// PoCL's own take a dozen instructions, the compiler's are one.
#ifdef HAS_ROUNDING
static inline FloatL floor_lane(FloatL a) { return __builtin_elementwise_floor(a); }
static inline FloatL ceil_lane(FloatL a) { return __builtin_elementwise_ceil(a); }
#else
static inline FloatL floor_lane(FloatL a) { return floor(a); }
static inline FloatL ceil_lane(FloatL a) { return ceil(a); }
#endif

static inline float greatest_float8(float8 v)
{
  float4 four = v.lo > v.hi ? v.lo : v.hi;
  float2 two = four.lo > four.hi ? four.lo : four.hi;
  return two.x > two.y ? two.x : two.y;
}

static inline float greatest_float16(float16 v) { return greatest_float8(v.lo > v.hi ? v.lo : v.hi); }

static inline UintL min_uint(UintL a, UintL b) { return a < b ? a : b; }
static inline UintL max_uint(UintL a, UintL b) { return a > b ? a : b; }

// a / b for a < 2^23, b > 0; vectors of integers are divided lane by lane, of floats at once.
static inline UintL divide_lane(UintL a, UintL b)
{
#if LANES == 1
  return a / b;
#else
  UintL quotient = LANE_AS_UINT(LANE_CONVERT_INT(LANE_CONVERT_FLOAT(a) / LANE_CONVERT_FLOAT(b))), one = UINTL(1);
  IntL left = LANE_AS_INT(a - quotient * b);
  quotient -= left < INTL(0) ? one : UINTL(0);
  return quotient + (left >= LANE_AS_INT(b) ? one : UINTL(0));
#endif
}

// The greatest lane.
static inline float greatest_lane(FloatL v)
{
#if LANES == 1
  return v;
#elif LANES == 16
  return greatest_float16(v);
#else
  return greatest_float8(v);
#endif
}

typedef struct Vec3L {
  FloatL x, y, z;
} Vec3L;

static inline Vec3L vec3l(FloatL x, FloatL y, FloatL z)
{
  Vec3L v = {x, y, z};
  return v;
}

static inline Vec3L add3(Vec3L a, Vec3L b) { return vec3l(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline Vec3L sub3(Vec3L a, Vec3L b) { return vec3l(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline Vec3L mul3(Vec3L a, Vec3L b) { return vec3l(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline Vec3L scale3(Vec3L a, FloatL s) { return vec3l(a.x * s, a.y * s, a.z * s); }
static inline FloatL dot3(Vec3L a, Vec3L b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline Vec3L cross3(Vec3L a, Vec3L b)
{
  return vec3l(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline Vec3L select3(IntL mask, Vec3L a, Vec3L b)
{
  return vec3l(mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z);
}

// Unit vector; a zero vector stays zero.
static inline Vec3L unit3(Vec3L a)
{
  FloatL squared = dot3(a, a);
#if LANES == 1
  return scale3(a, squared > 0 ? rsqrt(squared) : 0);  // to 2 ulp, as quotient and root are on many a GPU
#else
  return scale3(a, squared > FLOATL(0) ? FLOATL(1) / sqrt(squared) : FLOATL(0));
#endif
}

static inline FloatL max_component3(Vec3L a) { return max_lane(max_lane(a.x, a.y), a.z); }

#pragma once

// Arithmetic on eight lanes, for the kernels only. It is compiled once for each instruction set, so
// all functions are in an unnamed namespace, and this file includes no header with inline
// functions.

#include <stdint.h>
#include <string.h>

namespace steadymap {
namespace {

#define STEADYMAP_INLINE inline __attribute__((always_inline))

constexpr int kLanes = 8;
using Floats = float __attribute__((vector_size(32)));
using Integers = int32_t __attribute__((vector_size(32)));
using Words = uint32_t __attribute__((vector_size(32)));

constexpr Floats kLaneIndex = {0.0F, 1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F, 7.0F};

/// A value larger than every depth, with a finite square.
constexpr float kFarM = 1e9F;

STEADYMAP_INLINE Floats Splat(float value) { return value - Floats{}; }

STEADYMAP_INLINE Floats Load(const float* from) {
  Floats value;
  memcpy(&value, from, sizeof(value));
  return value;
}

STEADYMAP_INLINE void Store(Floats value, float* to) { memcpy(to, &value, sizeof(value)); }

/// Each lane of `mask` must be all ones or all zeros, as in the result of a comparison.
STEADYMAP_INLINE Floats Select(Integers mask, Floats yes, Floats no) {
#ifdef __AVX2__
  return __builtin_ia32_blendvps256(no, yes, reinterpret_cast<Floats>(mask));
#else
  return reinterpret_cast<Floats>((mask & reinterpret_cast<Integers>(yes)) |
                                  (~mask & reinterpret_cast<Integers>(no)));
#endif
}

STEADYMAP_INLINE Floats Min(Floats a, Floats b) { return a < b ? a : b; }

STEADYMAP_INLINE Floats Max(Floats a, Floats b) { return a > b ? a : b; }

STEADYMAP_INLINE Floats Abs(Floats value) {
  return reinterpret_cast<Floats>(reinterpret_cast<Words>(value) & 0x7FFFFFFFU);
}

/// Correctly rounded on every processor. On x86-64 not `__builtin_sqrtf`, whose error handling
/// prevents vectorisation of the lanes.
STEADYMAP_INLINE Floats Sqrt(Floats value) {
#ifdef __AVX2__
  return __builtin_ia32_sqrtps256(value);
#elif defined(__SSE__)
  const auto low = __builtin_ia32_sqrtps(__builtin_shufflevector(value, value, 0, 1, 2, 3));
  const auto high = __builtin_ia32_sqrtps(__builtin_shufflevector(value, value, 4, 5, 6, 7));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  for (int lane = 0; lane < kLanes; ++lane) value[lane] = __builtin_sqrtf(value[lane]);
  return value;
#endif
}

/// Rounds to the nearest integer, ties to even, for magnitudes below 2^22.
STEADYMAP_INLINE Floats Round(Floats value) {
  constexpr float kMagic = 12582912.0F;  // 1.5 * 2^23: a sum with it has no fractional bits.
  return (value + kMagic) - kMagic;
}

/// Returns one bit per lane.
STEADYMAP_INLINE uint32_t ToBits(Integers mask) {
#ifdef __AVX2__
  return static_cast<uint32_t>(__builtin_ia32_movmskps256(reinterpret_cast<Floats>(mask)));
#else
  uint32_t bits = 0;
  for (int lane = 0; lane < kLanes; ++lane) bits |= (mask[lane] != 0 ? 1U : 0U) << lane;
  return bits;
#endif
}

/// Transposes an 8 x 8 matrix.
STEADYMAP_INLINE void Transpose(Floats rows[kLanes]) {
  Floats pairs[kLanes];
  for (int i = 0; i < kLanes; i += 2) {
    pairs[i] = __builtin_shufflevector(rows[i], rows[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
    pairs[i + 1] = __builtin_shufflevector(rows[i], rows[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
  }
  Floats quads[kLanes];
  for (int i = 0; i < kLanes; i += 4) {
    quads[i] = __builtin_shufflevector(pairs[i], pairs[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
    quads[i + 1] = __builtin_shufflevector(pairs[i], pairs[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    quads[i + 2] = __builtin_shufflevector(pairs[i + 1], pairs[i + 3], 0, 1, 8, 9, 4, 5, 12, 13);
    quads[i + 3] = __builtin_shufflevector(pairs[i + 1], pairs[i + 3], 2, 3, 10, 11, 6, 7, 14, 15);
  }
  for (int i = 0; i < 4; ++i) {
    rows[i] = __builtin_shufflevector(quads[i], quads[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    rows[i + 4] = __builtin_shufflevector(quads[i], quads[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

}  // namespace
}  // namespace steadymap

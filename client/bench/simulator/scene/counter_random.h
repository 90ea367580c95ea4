#pragma once

#include <cstdint>

/// Counter-based random numbers: each number is a function of its key, not of earlier draws, so the
/// noise of a pixel is independent of the order of computation.
namespace steadymap {

/// Mixes 64 bits so that every input bit affects every output bit (an xor-shift-multiply
/// bijection).
constexpr std::uint64_t Scramble(std::uint64_t bits) {
  bits ^= bits >> 32;
  bits *= 0xd6e8feb86659fd93ULL;
  bits ^= bits >> 32;
  bits *= 0xd6e8feb86659fd93ULL;
  bits ^= bits >> 32;
  return bits;
}

/// Returns a key for the pair of `key` and `counter`; chain it for longer tuples.
constexpr std::uint64_t Combine(std::uint64_t key, std::uint64_t counter) {
  return Scramble(key + 0x9e3779b97f4a7c15ULL * (counter + 1));
}

/// Returns a uniform number in [0, 1) from the upper 53 bits of `key`.
constexpr double UniformOf(std::uint64_t key) {
  return static_cast<double>(key >> 11) * (1.0 / 9007199254740992.0);
}

/// Returns a uniform number in [low, high) for the pair of `key` and `counter`.
constexpr double UniformBetween(std::uint64_t key, std::uint64_t counter, double low, double high) {
  return low + (high - low) * UniformOf(Combine(key, counter));
}

}  // namespace steadymap

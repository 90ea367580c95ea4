#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

/// The smallest unit of a volume: 8 x 8 x 8 voxels. A volume changes, is stored and is sent leaf by
/// leaf.
///
/// Voxel convention: voxel (i, j, k) of a volume has its centre at (i, j, k) times the voxel size
/// in the volume's frame (the world frame for the background). Within a leaf, voxel (x, y, z)
/// counted from the leaf's origin stands at offset `x * 64 + y * 8 + z`, as in an OpenVDB leaf
/// node.
///
/// Canonical voxel (decisions.md 1): a distance is a whole multiple of a step, a weight of
/// `kWeightUnit`, so memory, disk and wire hold the same bits. They are no finer than needed: what
/// settles stops changing the sooner, and noise is not sent and stored to its last digit.
namespace steadymap {

inline constexpr int kLeafSide = 8;
inline constexpr std::size_t kLeafVoxels = 512;

/// Steps from the surface to the truncation distance: 0.3 mm each where it is 15 cm, a seventeenth
/// of the noise that settled voxels ignore.
inline constexpr int kMaxDistanceSteps = 511;

/// Weights are fixed-point: 1.0 is one look from one metre, straight on. What weighs less than a
/// unit, such as the far end of the band behind a surface seen aslant, is not fused.
inline constexpr float kWeightUnit = 1.0F / 256.0F;

/// The voxel size of a map and what follows from it.
struct VoxelScale {
  double voxel_size_m = 0.05;
  double truncation_m = 0.15;

  /// Metres that one step of a stored distance stands for.
  float distance_step_m() const {
    return static_cast<float>(truncation_m / static_cast<double>(kMaxDistanceSteps));
  }

  double leaf_size_m() const { return voxel_size_m * kLeafSide; }

  friend bool operator==(const VoxelScale&, const VoxelScale&) = default;
};

/// Index of a leaf's lowest voxel; every coordinate is a multiple of `kLeafSide`.
struct LeafOrigin {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend constexpr auto operator<=>(const LeafOrigin&, const LeafOrigin&) = default;
};

/// The leaf that holds voxel (`x`, `y`, `z`).
constexpr LeafOrigin LeafOf(std::int32_t x, std::int32_t y, std::int32_t z) {
  return {x & ~(kLeafSide - 1), y & ~(kLeafSide - 1), z & ~(kLeafSide - 1)};
}

/// Place of a voxel in its leaf's arrays, from its index in the volume.
constexpr std::size_t OffsetInLeaf(std::int32_t x, std::int32_t y, std::int32_t z) {
  return static_cast<std::size_t>(((x & (kLeafSide - 1)) << 6) | ((y & (kLeafSide - 1)) << 3) |
                                  (z & (kLeafSide - 1)));
}

/// One bit a voxel; word `x` holds bits `y * 8 + z`. Set where the voxel was observed.
using LeafMask = std::array<std::uint64_t, kLeafSide>;

constexpr bool IsSet(const LeafMask& mask, std::size_t offset) {
  return ((mask[offset >> 6] >> (offset & 63)) & 1U) != 0;
}

constexpr void SetBit(std::size_t offset, LeafMask* mask) {
  (*mask)[offset >> 6] |= std::uint64_t{1} << (offset & 63);
}

constexpr void ClearBit(std::size_t offset, LeafMask* mask) {
  (*mask)[offset >> 6] &= ~(std::uint64_t{1} << (offset & 63));
}

/// The number of voxels that are set.
constexpr std::size_t CountBits(const LeafMask& mask) {
  std::size_t count = 0;
  for (const std::uint64_t word : mask) count += static_cast<std::size_t>(std::popcount(word));
  return count;
}

/// Calls `visit(offset)` for every voxel that is set, by rising offset.
template <typename Visit>
constexpr void ForEachBit(const LeafMask& mask, Visit visit) {
  for (std::size_t word = 0; word < mask.size(); ++word) {
    for (std::uint64_t bits = mask[word]; bits != 0; bits &= bits - 1) {
      visit(word * 64 + static_cast<std::size_t>(std::countr_zero(bits)));
    }
  }
}

/// The voxels of one leaf, by value. Voxels that are not observed hold zeros.
struct LeafVoxels {
  alignas(32) std::array<float, kLeafVoxels> distance_m{};
  alignas(32) std::array<float, kLeafVoxels> weight{};
  /// Red, green, blue and the number of looks (at most 255) in bytes 0 to 3; 0 looks: not known.
  alignas(32) std::array<std::uint32_t, kLeafVoxels> color{};
  LeafMask observed{};
  bool has_color = false;  ///< Whether any voxel has a colour.

  friend bool operator==(const LeafVoxels&, const LeafVoxels&) = default;
};

/// Write access to the arrays of one leaf. Null where there is no leaf.
struct LeafEdit {
  float* distance_m = nullptr;     ///< `kLeafVoxels` values, metres.
  float* weight = nullptr;         ///< `kLeafVoxels` values.
  std::uint32_t* color = nullptr;  ///< As in LeafVoxels; null where the leaf has no colour.
  LeafMask observed{};             ///< A copy: what is observed before the edit.

  explicit operator bool() const { return distance_m != nullptr; }
};

/// Read access to one leaf of a volume, valid as long as the volume. Null where there is no leaf.
struct LeafView {
  const float* distance_m = nullptr;     ///< `kLeafVoxels` values, metres.
  const float* weight = nullptr;         ///< `kLeafVoxels` values.
  const std::uint32_t* color = nullptr;  ///< As in LeafVoxels; null where the leaf has no colour.
  LeafMask observed{};

  explicit operator bool() const { return distance_m != nullptr; }
};

/// Valid as long as `leaf`.
inline LeafView ViewOf(const LeafVoxels& leaf) {
  return {leaf.distance_m.data(),
          leaf.weight.data(),
          leaf.has_color ? leaf.color.data() : nullptr,
          leaf.observed};
}

/// Copies a leaf to `voxels`; zeros where there is none.
inline void CopyLeaf(const LeafView& leaf, LeafVoxels* voxels) {
  if (!leaf) {
    *voxels = LeafVoxels{};
    return;
  }
  std::copy_n(leaf.distance_m, kLeafVoxels, voxels->distance_m.begin());
  std::copy_n(leaf.weight, kLeafVoxels, voxels->weight.begin());
  voxels->has_color = leaf.color != nullptr;
  if (voxels->has_color) {
    std::copy_n(leaf.color, kLeafVoxels, voxels->color.begin());
  } else {
    voxels->color.fill(0);
  }
  voxels->observed = leaf.observed;
}

}  // namespace steadymap

template <>
struct std::hash<steadymap::LeafOrigin> {
  std::size_t operator()(const steadymap::LeafOrigin& origin) const noexcept {
    const auto mix = [](std::uint64_t value) { return value * 0x9E3779B97F4A7C15ULL; };
    std::uint64_t mixed = mix(static_cast<std::uint32_t>(origin.x >> 3));
    mixed = mix(mixed ^ static_cast<std::uint32_t>(origin.y >> 3));
    mixed = mix(mixed ^ static_cast<std::uint32_t>(origin.z >> 3));
    return static_cast<std::size_t>(mixed ^ (mixed >> 32));
  }
};

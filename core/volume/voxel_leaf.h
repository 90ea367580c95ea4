#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

/// A leaf: 8 x 8 x 8 voxels, the unit of change, storage and transfer of a volume.
///
/// Voxel convention: voxel (i, j, k) of a volume has its centre at (i, j, k) times the voxel size
/// in the frame of the volume (the world frame for the background). Within a leaf, the voxel at (x,
/// y, z) from the origin of the leaf has the offset `x * 64 + y * 8 + z`, as in an OpenVDB leaf
/// node.
///
/// Distances are stored in steps, weights in units, so memory, disk and wire have the same bits.
/// The steps are coarse on purpose: converged voxels stop changing earlier, and digits below the
/// noise are neither stored nor sent.
namespace steadymap {

inline constexpr int kLeafSide = 8;
inline constexpr std::size_t kLeafVoxels = 512;

/// Number of steps from the surface to the truncation distance: 0.3 mm each at 15 cm, 1/17 of the
/// noise that converged voxels ignore.
inline constexpr int kMaxDistanceSteps = 511;

/// Unit of the fixed-point weights. The weight 1.0 is one measurement from 1 m at normal incidence.
/// A voxel with the unit itself is extrapolated from the surface in front of it: it allows
/// interpolation at the surface, but gives none.
inline constexpr float kWeightUnit = 1.0F / 256.0F;

/// The signed distance from the surface and the weight of one voxel. Zero in an unobserved voxel.
struct Voxel {
  constexpr Voxel() = default;

  /// `distance_steps`: at most `kMaxDistanceSteps` on either side; `weight_units`: in [0, 65535].
  constexpr Voxel(int distance_steps, int weight_units)
      : bits(static_cast<std::uint32_t>(distance_steps) << 16 |
             (static_cast<std::uint32_t>(weight_units) & 0xFFFFU)) {}

  /// The distance in multiples of `VoxelScale::distance_step_m`, positive in front of the surface.
  constexpr int distance_steps() const { return static_cast<std::int32_t>(bits) >> 16; }

  /// The distance, metres. `distance_step_m`: `VoxelScale::distance_step_m`.
  constexpr float distance_m(float distance_step_m) const {
    return static_cast<float>(distance_steps()) * distance_step_m;
  }

  /// The weight in multiples of `kWeightUnit`.
  constexpr int weight_units() const { return static_cast<int>(bits & 0xFFFFU); }

  constexpr float weight() const { return static_cast<float>(weight_units()) * kWeightUnit; }

  friend constexpr bool operator==(const Voxel&, const Voxel&) = default;

  std::uint32_t bits = 0;  ///< The distance in the upper, the weight in the lower half.
};

/// The voxel size and truncation distance of a map, with derived values.
struct VoxelScale {
  double voxel_size_m = 0.05;
  double truncation_m = 0.15;

  /// Returns the step of stored distances, metres.
  float distance_step_m() const {
    return static_cast<float>(truncation_m / static_cast<double>(kMaxDistanceSteps));
  }

  /// Returns the distance of a voxel, metres.
  float distance_m(Voxel voxel) const { return voxel.distance_m(distance_step_m()); }

  double leaf_size_m() const { return voxel_size_m * kLeafSide; }

  friend bool operator==(const VoxelScale&, const VoxelScale&) = default;
};

/// The index of the lowest voxel of a leaf; every coordinate is a multiple of `kLeafSide`.
struct LeafOrigin {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend constexpr auto operator<=>(const LeafOrigin&, const LeafOrigin&) = default;
};

/// Returns the leaf that contains voxel (`x`, `y`, `z`).
constexpr LeafOrigin LeafOf(std::int32_t x, std::int32_t y, std::int32_t z) {
  return {x & ~(kLeafSide - 1), y & ~(kLeafSide - 1), z & ~(kLeafSide - 1)};
}

/// Returns the offset in the leaf's arrays of the voxel with index (`x`, `y`, `z`) in the volume.
constexpr std::size_t OffsetInLeaf(std::int32_t x, std::int32_t y, std::int32_t z) {
  return static_cast<std::size_t>(((x & (kLeafSide - 1)) << 6) | ((y & (kLeafSide - 1)) << 3) |
                                  (z & (kLeafSide - 1)));
}

/// One bit per voxel, set if the voxel is observed; word `x` holds bits `y * 8 + z`.
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

/// The voxels of one leaf, by value. Unobserved voxels are zero.
struct LeafVoxels {
  alignas(32) std::array<Voxel, kLeafVoxels> voxels{};
  /// Red, green, blue and the number of measurements (at most 255) in bytes 0 to 3; number 0:
  /// unknown.
  alignas(32) std::array<std::uint32_t, kLeafVoxels> color{};
  LeafMask observed{};
  bool has_color = false;  ///< True if any voxel has a colour.

  friend bool operator==(const LeafVoxels&, const LeafVoxels&) = default;
};

/// Write access to the arrays of one leaf. Null if the leaf does not exist.
struct LeafEdit {
  Voxel* voxels = nullptr;         ///< `kLeafVoxels` values.
  std::uint32_t* color = nullptr;  ///< See `LeafVoxels::color`; null if the leaf has none.
  LeafMask observed{};             ///< A copy of the mask before the edit.

  explicit operator bool() const { return voxels != nullptr; }
};

/// Read access to one leaf of a volume, valid as long as the volume. Null if it does not exist.
struct LeafView {
  const Voxel* voxels = nullptr;         ///< `kLeafVoxels` values.
  const std::uint32_t* color = nullptr;  ///< See `LeafVoxels::color`; null if the leaf has none.
  LeafMask observed{};

  explicit operator bool() const { return voxels != nullptr; }
};

/// Returns a view that is valid as long as `leaf`.
inline LeafView ViewOf(const LeafVoxels& leaf) {
  return {leaf.voxels.data(), leaf.has_color ? leaf.color.data() : nullptr, leaf.observed};
}

/// Copies a leaf to `voxels`; zeros if the leaf is null.
inline void CopyLeaf(const LeafView& leaf, LeafVoxels* voxels) {
  if (!leaf) {
    *voxels = LeafVoxels{};
    return;
  }
  std::copy_n(leaf.voxels, kLeafVoxels, voxels->voxels.begin());
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

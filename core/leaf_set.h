#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/voxel_leaf.h"

namespace steadymap {

/// Collects the leaves that a frame touches, each once. Made for many insertions of few distinct
/// leaves: neighbouring rays meet the same ones.
class LeafSet {
 public:
  /// A leaf's position in leaves, not voxels.
  struct LeafIndex {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
  };

  /// Empties the set. Leaves are then inserted relative to `base` and must lie within 2^20 of it.
  void Reset(LeafIndex base);

  /// Forgets what the rays before met; call where neighbours end.
  void StartRow();

  /// Inserts the leaf that holds `point` (in leaves, relative to the base), the `step`-th of its
  /// ray.
  void Insert(int step, const Eigen::Vector3f& point) {
    const auto at = static_cast<std::size_t>(step);
    const std::uint64_t key = KeyOf(point);
    if (at < last_keys_.size()) {
      if (last_keys_[at] == key) return;
      last_keys_[at] = key;
    }
    InsertKey(key);
  }

  /// The leaves in ascending order. Valid until the next call of a non-const function.
  const std::vector<LeafOrigin>& Sorted();

 private:
  static constexpr std::int64_t kBias = std::int64_t{1} << 20;
  static constexpr std::uint64_t kNoKey = ~std::uint64_t{0};
  static constexpr std::size_t kTrackedSteps = 64;

  static std::uint64_t Biased(float coordinate) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(coordinate)) + kBias);
  }

  static std::uint64_t KeyOf(const Eigen::Vector3f& point) {
    return Biased(point.x()) << 42 | Biased(point.y()) << 21 | Biased(point.z());
  }

  void InsertKey(std::uint64_t key);
  void Grow();

  LeafIndex base_;
  std::vector<std::uint64_t> last_keys_ = std::vector<std::uint64_t>(kTrackedSteps, kNoKey);
  std::vector<std::uint64_t> table_ =
      std::vector<std::uint64_t>(4096, kNoKey);  ///< Open addressing.
  std::vector<std::uint64_t> keys_;
  std::vector<LeafOrigin> sorted_;
};

}  // namespace steadymap

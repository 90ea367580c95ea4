#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// The set of leaves touched by a frame. Optimised for many insertions of few distinct leaves:
/// neighbouring rays cross the same leaves.
class LeafSet {
 public:
  /// The position of a leaf in leaves, not voxels.
  struct LeafIndex {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
  };

  /// Clears the set. Further leaves are inserted relative to `base` and must lie within 2^20 leaves
  /// of it.
  void Reset(LeafIndex base);

  /// Clears the keys of the previous segment. Call between segments that are not neighbours.
  void StartRow();

  /// Inserts every leaf on the segment from `from` to `to`, in leaves relative to the base.
  void InsertSegment(const Eigen::Vector3f& from, const Eigen::Vector3f& to);

  std::size_t size() const { return keys_.size(); }

  /// Returns the leaves in ascending order. Valid until the next call of a non-const function.
  const std::vector<LeafOrigin>& Sorted();

 private:
  static constexpr std::int32_t kBias = 1 << 20;
  static constexpr std::uint64_t kNoKey = ~std::uint64_t{0};
  static constexpr std::size_t kTrackedSteps = 16;

  static std::uint64_t KeyOf(const std::array<std::int32_t, 3>& leaf) {
    return static_cast<std::uint64_t>(leaf[0] + kBias) << 42 |
           static_cast<std::uint64_t>(leaf[1] + kBias) << 21 |
           static_cast<std::uint64_t>(leaf[2] + kBias);
  }

  /// Inserts the leaf `key`, number `step` along its segment.
  void Insert(std::size_t step, std::uint64_t key) {
    if (step < kTrackedSteps) {
      if (last_keys_[step] == key) return;
      last_keys_[step] = key;
    }
    InsertKey(key);
  }

  void InsertKey(std::uint64_t key);
  void Grow();

  LeafIndex base_;
  std::array<std::uint64_t, kTrackedSteps> last_keys_;  ///< Of the previous segment, by step.
  std::vector<std::uint64_t> table_ =
      std::vector<std::uint64_t>(4096, kNoKey);  ///< Open addressing.
  std::vector<std::uint64_t> keys_;
  std::vector<LeafOrigin> sorted_;
};

}  // namespace steadymap

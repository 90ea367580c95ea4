#include "core/volume/leaf_set.h"

#include <algorithm>
#include <limits>

namespace steadymap {
namespace {

std::size_t HashOf(std::uint64_t key) {
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 32);
}

/// Without SSE4.1, std::floor is a function call, too slow here.
std::int32_t Floor(float value) {
  const auto truncated = static_cast<std::int32_t>(value);
  return truncated - (value < static_cast<float>(truncated) ? 1 : 0);
}

}  // namespace

void LeafSet::Reset(LeafIndex base) {
  base_ = base;
  keys_.clear();
  std::fill(table_.begin(), table_.end(), kNoKey);
  StartRow();
}

void LeafSet::StartRow() { std::fill(last_keys_.begin(), last_keys_.end(), kNoKey); }

// The traversal of Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing" (1987).
// The number of crossings is computed in advance, so that rounding errors cannot extend the loop.
void LeafSet::InsertSegment(const Eigen::Vector3f& from, const Eigen::Vector3f& to) {
  std::array<std::int32_t, 3> leaf;
  std::array<std::int32_t, 3> direction;
  std::array<float, 3> next;   // Share of the segment at its next border crossing, by axis.
  std::array<float, 3> delta;  // Share between two borders.
  std::int32_t crossings = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto index = static_cast<Eigen::Index>(axis);
    leaf[axis] = Floor(from[index]);
    const std::int32_t span = Floor(to[index]) - leaf[axis];
    direction[axis] = span < 0 ? -1 : 1;
    crossings += span < 0 ? -span : span;
    const float length = to[index] - from[index];
    const auto border = static_cast<float>(leaf[axis] + (span < 0 ? 0 : 1));
    next[axis] =
        span == 0 ? std::numeric_limits<float>::infinity() : (border - from[index]) / length;
    delta[axis] = static_cast<float>(direction[axis]) / length;
  }
  Insert(0, KeyOf(leaf));
  for (std::int32_t i = 1; i <= crossings; ++i) {
    std::size_t axis = next[0] < next[1] ? 0 : 1;
    if (next[2] < next[axis]) axis = 2;
    leaf[axis] += direction[axis];
    next[axis] += delta[axis];
    Insert(static_cast<std::size_t>(i), KeyOf(leaf));
  }
}

void LeafSet::InsertKey(std::uint64_t key) {
  const std::size_t mask = table_.size() - 1;
  std::size_t place = HashOf(key) & mask;
  while (table_[place] != kNoKey) {
    if (table_[place] == key) return;
    place = (place + 1) & mask;
  }
  table_[place] = key;
  keys_.push_back(key);
  if (keys_.size() * 2 > table_.size()) Grow();
}

void LeafSet::Grow() {
  table_.assign(table_.size() * 2, kNoKey);
  const std::size_t mask = table_.size() - 1;
  for (const std::uint64_t key : keys_) {
    std::size_t place = HashOf(key) & mask;
    while (table_[place] != kNoKey) place = (place + 1) & mask;
    table_[place] = key;
  }
}

const std::vector<LeafOrigin>& LeafSet::Sorted() {
  std::sort(keys_.begin(), keys_.end());
  sorted_.clear();
  sorted_.reserve(keys_.size());
  constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
  const auto voxel = [](std::int32_t base, std::uint64_t biased) {
    const std::int64_t leaf = base + static_cast<std::int64_t>(biased) - kBias;
    return static_cast<std::int32_t>(leaf * kLeafSide);
  };
  for (const std::uint64_t key : keys_) {
    sorted_.push_back({voxel(base_.x, key >> 42),
                       voxel(base_.y, (key >> 21) & kMask),
                       voxel(base_.z, key & kMask)});
  }
  return sorted_;
}

}  // namespace steadymap

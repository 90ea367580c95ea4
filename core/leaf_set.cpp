#include "core/leaf_set.h"

#include <algorithm>

namespace steadymap {
namespace {

std::size_t HashOf(std::uint64_t key) {
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 32);
}

}  // namespace

void LeafSet::Reset(LeafIndex base) {
  base_ = base;
  keys_.clear();
  std::fill(table_.begin(), table_.end(), kNoKey);
  StartRow();
}

void LeafSet::StartRow() { std::fill(last_keys_.begin(), last_keys_.end(), kNoKey); }

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

#include "core/volume/leaf_patch.h"

#include <cstddef>
#include <cstdint>

namespace steadymap {
namespace {

bool IsAsBefore(const LeafView& before, const LeafView& after, std::size_t offset) {
  const bool has_color = after.color != nullptr;
  return before.voxels[offset] == after.voxels[offset] && (before.color != nullptr) == has_color &&
         (!has_color || before.color[offset] == after.color[offset]);
}

}  // namespace

std::optional<LeafView> FindLeafPatch(const LeafView& before, const LeafView& after) {
  if (!before || !after || (before.color != nullptr && after.color == nullptr)) return std::nullopt;
  LeafView patch = after;
  for (std::size_t word = 0; word < patch.observed.size(); ++word) {
    if ((before.observed[word] & ~after.observed[word]) != 0) return std::nullopt;
  }
  ForEachBit(before.observed, [&](std::size_t offset) {
    if (IsAsBefore(before, after, offset)) ClearBit(offset, &patch.observed);
  });
  return patch;
}

void ApplyLeafPatch(const LeafVoxels& patch, LeafVoxels* leaf) {
  leaf->has_color = leaf->has_color || patch.has_color;
  for (std::size_t word = 0; word < patch.observed.size(); ++word) {
    leaf->observed[word] |= patch.observed[word];
  }
  ForEachBit(patch.observed, [&](std::size_t offset) {
    leaf->voxels[offset] = patch.voxels[offset];
    leaf->color[offset] = patch.color[offset];
  });
}

}  // namespace steadymap

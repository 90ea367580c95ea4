#pragma once

#include <optional>
#include <string>

#include "core/volume/leaf_patch.h"
#include "core/volume/tsdf_codec.h"

#include "steadymap/v1/volume.pb.h"

namespace steadymap::testing {

/// Returns the packed leaf after `message`; `known` is the packed leaf before it, empty if it did
/// not exist. None for a patch that is damaged or has no leaf to apply to.
inline std::optional<std::string> TakePackedLeaf(const v1::PackedLeaf& message,
                                                 const std::string& known) {
  if (!message.is_patch()) return message.packed();
  LeafVoxels leaf;
  LeafVoxels patch;
  if (known.empty() || message.packed().empty() || !UnpackLeaf(known, &leaf).ok() ||
      !UnpackLeaf(message.packed(), &patch).ok()) {
    return std::nullopt;
  }
  ApplyLeafPatch(patch, &leaf);
  return PackLeaf(ViewOf(leaf));
}

}  // namespace steadymap::testing

#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/types/identifiers.h"
#include "core/volume/voxel_leaf.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap::benchmarks {

/// Content received by a watcher, by category. Bytes are those of serialized fields.
struct DeltaAccount {
  double background_bytes = 0.0;
  double object_leaf_bytes = 0.0;
  double object_state_bytes = 0.0;
  double event_bytes = 0.0;
  double other_bytes = 0.0;  ///< Progress and message framing.

  double whole_bytes = 0.0;     ///< Of all leaves, if each were sent completely.
  double leaves = 0.0;          ///< Sent.
  double patches = 0.0;         ///< Leaves sent as patches, without unchanged voxels.
  double voxels = 0.0;          ///< Observed voxels of those leaves, sent or not.
  double new_voxels = 0.0;      ///< Not observed before.
  double weighed_voxels = 0.0;  ///< Observed before, changed weight, same distance.
  double moved_voxels = 0.0;    ///< Observed before, changed distance.
  double young_voxels = 0.0;    ///< Moved voxels with a weight below 2.
  double moved_m = 0.0;         ///< Sum of the changes of the distances.
  double calm_leaves = 0.0;     ///< Leaves with at most 5 % changed voxels.
  double moved_objects = 0.0;   ///< Object states sent.

  double bytes() const {
    return background_bytes + object_leaf_bytes + object_state_bytes + event_bytes + other_bytes;
  }
};

/// Accounts for the messages of one watcher; stores every leaf to determine its changes.
class DeltaBookkeeper {
 public:
  explicit DeltaBookkeeper(const VoxelScale& scale) : scale_(scale) {}

  /// Throws `std::runtime_error` for a leaf that cannot be unpacked.
  void Book(const v1::WatchMapResponse& message, DeltaAccount* account);

 private:
  using LeafName = std::pair<std::uint64_t, std::array<std::int32_t, 3>>;

  void BookLeaf(const v1::PackedLeaf& leaf, DeltaAccount* account);

  const VoxelScale scale_;
  std::map<LeafName, LeafVoxels> leaves_;
};

}  // namespace steadymap::benchmarks

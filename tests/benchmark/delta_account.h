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

/// What a watcher got, by what it is about. Bytes are of serialized fields.
struct DeltaAccount {
  double background_bytes = 0.0;
  double object_leaf_bytes = 0.0;
  double object_state_bytes = 0.0;
  double event_bytes = 0.0;
  double other_bytes = 0.0;  ///< Progress, and what surrounds the rest.

  double whole_bytes = 0.0;     ///< Of leaves, had they all been sent whole.
  double leaves = 0.0;          ///< Sent.
  double patches = 0.0;         ///< Of those, sent without the voxels that are as they were.
  double voxels = 0.0;          ///< Observed ones in those leaves, sent or not.
  double new_voxels = 0.0;      ///< Of those, not observed before.
  double weighed_voxels = 0.0;  ///< Observed before, with another weight and the same distance.
  double moved_voxels = 0.0;    ///< Observed before, with another distance.
  double young_voxels = 0.0;    ///< Of the moved ones, those that weighed less than 2.
  double moved_m = 0.0;         ///< Sum of how far the distances moved.
  double calm_leaves = 0.0;     ///< Leaves in which no more than one voxel in twenty changed.
  double moved_objects = 0.0;   ///< Object states sent.

  double bytes() const {
    return background_bytes + object_leaf_bytes + object_state_bytes + event_bytes + other_bytes;
  }
};

/// Books the messages of one watcher, and remembers every leaf to tell what changed in it.
class DeltaBookkeeper {
 public:
  explicit DeltaBookkeeper(const VoxelScale& scale) : scale_(scale) {}

  /// Throws `std::runtime_error` for a leaf that does not unpack.
  void Book(const v1::WatchMapResponse& message, DeltaAccount* account);

 private:
  using LeafName = std::pair<std::uint64_t, std::array<std::int32_t, 3>>;

  void BookLeaf(const v1::PackedLeaf& leaf, DeltaAccount* account);

  const VoxelScale scale_;
  std::map<LeafName, LeafVoxels> leaves_;
};

}  // namespace steadymap::benchmarks

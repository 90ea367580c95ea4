#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/map/map_filter.h"
#include "core/map/map_snapshot.h"
#include "core/types/cancellation.h"
#include "core/types/identifiers.h"
#include "core/volume/voxel_leaf.h"
#include "server/store/model/store.h"

namespace steadymap {

/// The objects that a filter shows at one revision, by ascending id.
using ShownObjects = std::vector<ObjectId>;

/// The content of a step for one watcher: the keys of the changes within its filter, and the
/// snapshot that contains the values. Its size does not depend on the size of the values.
struct StepPlan {
  std::optional<Revision> from;  ///< None: a snapshot, with everything that the filter shows.
  std::uint64_t commits = 0;     ///< Commits between `from` and the snapshot.
  std::vector<ObjectId> removed{};
  std::vector<ObjectId> objects{};  ///< By ascending id.
  std::vector<LeafKey> leaves{};    ///< Sorted.
  /// Objects of `objects` that the watcher does not have; their leaves are sent whole. By ascending
  /// id.
  std::vector<ObjectId> joined{};
  std::shared_ptr<const ShownObjects> shown;  ///< Objects shown after the step.
  std::shared_ptr<const MapSnapshot> snapshot;
  /// The map at `from`; null if it is no longer in memory: leaves are then sent whole.
  std::shared_ptr<const MapSnapshot> base{};

  /// Returns the changed voxels of a leaf of the step, from `FindLeafPatch`; none if the leaf must
  /// be sent whole. Valid as long as `snapshot`.
  std::optional<LeafView> FindPatch(const LeafKey& key) const;

  bool IsEmpty() const { return removed.empty() && objects.empty() && leaves.empty(); }
};

/// Makes a step with everything that the filter shows of a map. Cost: a pass over all objects and
/// leaves, which stops early on cancellation; the plan must not be used then.
StepPlan MakeSnapshotStep(const MapFilter& filter,
                          std::shared_ptr<const MapSnapshot> snapshot,
                          const Cancellation& cancellation = {});

/// Makes the step of a watcher that has everything that the filter showed at revision `from`.
/// `shown` lists the objects shown then; if it is null (unknown), changed objects are sent whole.
/// Cost: proportional to the changes; plus a pass over the shown objects if their set changes, or
/// over all objects if `shown` is null.
StepPlan MakeDeltaStep(const MapFilter& filter,
                       const ChangeList& changes,
                       Revision from,
                       const std::shared_ptr<const ShownObjects>& shown,
                       std::shared_ptr<const MapSnapshot> snapshot);

/// Returns the objects that a filter shows. Cost: a pass over all objects.
std::shared_ptr<const ShownObjects> ShownBy(const MapFilter& filter, const MapSnapshot& snapshot);

}  // namespace steadymap

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

/// The objects that a filter shows at one revision, by rising id.
using ShownObjects = std::vector<ObjectId>;

/// What of a map a watcher is to be told: the names of what changed within its filter, and the
/// snapshot to take the values from. Small, however large the values are.
struct StepPlan {
  std::optional<Revision> from;  ///< None: a snapshot, everything that the filter shows.
  std::uint64_t commits = 0;     ///< Between `from` and the snapshot.
  std::vector<ObjectId> removed{};
  std::vector<ObjectId> objects{};  ///< By rising id.
  std::vector<LeafKey> leaves{};    ///< Sorted.
  /// Of `objects`, those that the watcher does not have: their leaves go out whole. By rising id.
  std::vector<ObjectId> joined{};
  std::shared_ptr<const ShownObjects> shown;  ///< After the step.
  std::shared_ptr<const MapSnapshot> snapshot;
  /// The map at `from`; null if nobody has it any more: then leaves go out whole.
  std::shared_ptr<const MapSnapshot> base{};

  /// The voxels that a leaf of the step has new, as `FindLeafPatch` tells; none if it is to be sent
  /// whole. Valid as long as `snapshot`.
  std::optional<LeafView> FindPatch(const LeafKey& key) const;

  bool IsEmpty() const { return removed.empty() && objects.empty() && leaves.empty(); }
};

/// Everything that the filter shows of a map. Cost: a pass over all objects and leaves. Ends early
/// once `cancellation` says so; the plan is then of no use.
StepPlan MakeSnapshotStep(const MapFilter& filter,
                          std::shared_ptr<const MapSnapshot> snapshot,
                          const Cancellation& cancellation = {});

/// What a step brings a watcher who has what the filter showed at revision `from`; `shown` says
/// which objects those were, and is null where nobody knows any more: then objects that changed are
/// sent whole. Cost: that of what changed, and of the objects of the map if their number shown
/// changes.
StepPlan MakeDeltaStep(const MapFilter& filter,
                       const ChangeList& changes,
                       Revision from,
                       const std::shared_ptr<const ShownObjects>& shown,
                       std::shared_ptr<const MapSnapshot> snapshot);

/// The objects that a filter shows. Cost: a pass over all objects.
std::shared_ptr<const ShownObjects> ShownBy(const MapFilter& filter, const MapSnapshot& snapshot);

}  // namespace steadymap

#pragma once

#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "core/map/map_object.h"
#include "core/map/map_snapshot.h"
#include "core/map/object_event.h"
#include "core/map/robot_state.h"
#include "core/types/identifiers.h"
#include "core/types/map_config.h"
#include "core/types/timestamp.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// The new state of one leaf; `packed` as in `tsdf_codec.h`, empty if the leaf is gone.
struct LeafChange {
  LeafKey key;
  std::string packed;

  friend bool operator==(const LeafChange&, const LeafChange&) = default;
};

/// The new state of one object; none if it is forgotten: then all its leaves are gone too.
struct ObjectChange {
  ObjectId id;
  std::optional<ObjectState> state;

  friend bool operator==(const ObjectChange&, const ObjectChange&) = default;
};

/// The new state of one block of free space.
struct FreeBlockChange {
  LeafOrigin origin;
  LeafMask cells{};

  friend bool operator==(const FreeBlockChange&, const FreeBlockChange&) = default;
};

/// The new state of one robot; none if it is forgotten.
struct RobotChange {
  SensorName sensor;
  std::optional<RobotState> state;

  friend bool operator==(const RobotChange&, const RobotChange&) = default;
};

/// What takes a map from one revision to another: states, never operations, so that a delta may be
/// applied twice or merged without harm. The store, recovery and watchers use the same one.
struct MapDelta {
  Revision from;                               ///< The revision that the delta applies to.
  Revision to;                                 ///< The one that it leads to; not below `from`.
  Timestamp last_capture_time;                 ///< Of the newest frame in `to`.
  ObjectId newest_object{};                    ///< As in `MapSnapshot`, in `to`.
  EventNumber last_event{};                    ///< As in `MapSnapshot`, in `to`.
  std::vector<SemanticClass> added_classes{};  ///< As in `MapSnapshot`, in `to`: all of them.
  std::vector<ObjectChange> objects{};         ///< By rising id, no id twice.
  std::vector<LeafChange> leaves{};            ///< Sorted by key, no key twice.
  std::vector<FreeBlockChange> free_blocks{};  ///< Sorted by origin, no origin twice.
  std::vector<RobotChange> robots{};           ///< Sorted by id, no id twice.
  std::vector<ObjectEvent> events{};           ///< In the order they happened.

  friend bool operator==(const MapDelta&, const MapDelta&) = default;
};

/// The delta that takes `before` to `after`, but for the events, which no map holds. Both must be
/// of one map (same scale, asserted).
MapDelta Diff(const MapSnapshot& before, const MapSnapshot& after);

/// Takes `snapshot` to `delta.to`.
/// Errors: `FailedPrecondition` if the snapshot is not at a revision in [`delta.from`, `delta.to`];
/// `DataLoss` for a damaged leaf, or one of an object that is not there. The snapshot is unchanged
/// after the first, undefined after the second.
absl::Status Apply(const MapDelta& delta, MapSnapshot* snapshot);

/// The delta that does what `first` and then `second` do. `second.from` must equal `first.to`
/// (asserted). Associative; `Apply(Merge(a, b), m) == Apply(b, Apply(a, m))`.
MapDelta Merge(const MapDelta& first, const MapDelta& second);

}  // namespace steadymap

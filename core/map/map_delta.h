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

/// The new state of one leaf. `packed` has the format of `tsdf_codec.h`; empty if the leaf is
/// removed.
struct LeafChange {
  LeafKey key;
  std::string packed;

  friend bool operator==(const LeafChange&, const LeafChange&) = default;
};

/// The new state of one object; none if the object is removed, together with all its leaves.
struct ObjectChange {
  ObjectId id;
  std::optional<ObjectState> state;

  friend bool operator==(const ObjectChange&, const ObjectChange&) = default;
};

/// The new state of one block of free space.
struct FreeBlockChange {
  LeafOrigin origin;
  FreeBlock block;

  friend bool operator==(const FreeBlockChange&, const FreeBlockChange&) = default;
};

/// The new state of one robot; none if it is removed.
struct RobotChange {
  SensorName sensor;
  std::optional<RobotState> state;

  friend bool operator==(const RobotChange&, const RobotChange&) = default;
};

/// The changes of a map between two revisions, as new states. Its application is therefore
/// idempotent, and deltas can be merged. The store, recovery and watchers use the same delta.
struct MapDelta {
  Revision from;                               ///< The delta applies to this revision.
  Revision to;                                 ///< The resulting revision; not below `from`.
  Timestamp last_capture_time;                 ///< Of the newest frame in `to`.
  ObjectId newest_object{};                    ///< See `MapSnapshot`; the value in `to`.
  EventNumber last_event{};                    ///< See `MapSnapshot`; the value in `to`.
  std::vector<SemanticClass> added_classes{};  ///< See `MapSnapshot`; the complete list in `to`.
  std::vector<ObjectChange> objects{};         ///< By increasing id, without duplicates.
  std::vector<LeafChange> leaves{};            ///< By increasing key, without duplicates.
  std::vector<FreeBlockChange> free_blocks{};  ///< By increasing origin, without duplicates.
  std::vector<RobotChange> robots{};           ///< By increasing sensor, without duplicates.
  std::vector<ObjectEvent> events{};           ///< In order of occurrence.

  friend bool operator==(const MapDelta&, const MapDelta&) = default;
};

/// Computes the delta from `before` to `after`, without events, since snapshots contain none. Both
/// must be snapshots of one map (equal scale, asserted).
MapDelta Diff(const MapSnapshot& before, const MapSnapshot& after);

/// Advances `snapshot` to `delta.to`. Errors: `FailedPrecondition` if the revision of the snapshot
/// is not in [`delta.from`, `delta.to`]; the snapshot is then unchanged. `DataLoss` for a corrupt
/// leaf, or a leaf of an object that does not exist; the snapshot is then undefined.
absl::Status Apply(const MapDelta& delta, MapSnapshot* snapshot);

/// Merges two consecutive deltas into one. `second.from` must equal `first.to` (asserted).
/// Associative; `Apply(Merge(a, b), m) == Apply(b, Apply(a, m))`.
MapDelta Merge(const MapDelta& first, const MapDelta& second);

}  // namespace steadymap

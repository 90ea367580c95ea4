#pragma once

#include <compare>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "core/identifiers.h"
#include "core/object_event.h"
#include "core/timestamp.h"
#include "core/voxel_leaf.h"

namespace steadymap {

struct MapSnapshot;

/// Names one leaf of a map: whose volume, and where in it.
struct LeafKey {
  ObjectId object;
  LeafOrigin origin;

  friend constexpr auto operator<=>(const LeafKey&, const LeafKey&) = default;
};

/// The new state of one leaf; `packed` as in `tsdf_codec.h`, empty if the leaf is gone.
struct LeafChange {
  LeafKey key;
  std::string packed;

  friend bool operator==(const LeafChange&, const LeafChange&) = default;
};

/// What takes a map from one revision to another: states, never operations, so that a delta may be
/// applied twice or merged without harm. The store, recovery and watchers use the same one.
struct MapDelta {
  Revision from;                      ///< The revision that the delta applies to.
  Revision to;                        ///< The revision that it leads to; not below `from`.
  Timestamp last_capture_time;        ///< Of the newest frame in `to`.
  std::vector<LeafChange> leaves;     ///< Sorted by key, no key twice.
  std::vector<ObjectEvent> events{};  ///< In the order they happened.

  friend bool operator==(const MapDelta&, const MapDelta&) = default;
};

/// The delta that takes `before` to `after`. Both must be of one map (same scale, asserted).
MapDelta Diff(const MapSnapshot& before, const MapSnapshot& after);

/// Takes `snapshot` to `delta.to`.
/// Errors: `FailedPrecondition` if the snapshot is not at a revision in [`delta.from`, `delta.to`];
/// `DataLoss` for a damaged leaf. The snapshot is unchanged after the first, undefined after the
/// second.
absl::Status Apply(const MapDelta& delta, MapSnapshot* snapshot);

/// The delta that does what `first` and then `second` do. `second.from` must equal `first.to`
/// (asserted). Associative; `Apply(Merge(a, b), m) == Apply(b, Apply(a, m))`.
MapDelta Merge(const MapDelta& first, const MapDelta& second);

}  // namespace steadymap

#pragma once

#include <cstddef>
#include <vector>

#include "core/association/association.h"
#include "core/association/sample_grid.h"
#include "core/map/object_event.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

/// Makes one object of two that turn out to be one.
namespace steadymap {

/// When surfaces that a frame shows connected are one object.
struct MergeParameters {
  /// So many neighbouring samples must be connected; 0: objects never merge.
  std::size_t contacts = 8;
  /// Both came to stand there within so long, on one visit: what is put beside something later is
  /// another thing, seconds.
  double recent_s = 20.0;
};

/// Gives `into` what is known of `from`, and forgets `from`; tells it if the map had shown `from`.
/// The objects must share their lattice (asserted).
void MergeObjects(TrackedObject* into, TrackedObject* from, WorkingMap* map);

/// Tells that an object of the map turned out to be part of another one.
void TellMerged(const TrackedObject& from, EventReason reason, ObjectId into, WorkingMap* map);

/// Merges the objects in view of one class and one visit whose surfaces are connected in the frame.
/// Of two the one stays that the map shows, of equals the older.
void MergeConnected(const SampleGrid& samples,
                    const Association& association,
                    const std::vector<ObjectInView>& in_view,
                    const MergeParameters& parameters,
                    WorkingMap* map);

}  // namespace steadymap

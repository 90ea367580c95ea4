#pragma once

#include <set>
#include <vector>

#include <absl/status/status.h>

#include "client/map/mirror_step.h"
#include "client/watch/watch_sequence.h"
#include "core/map/map_edits.h"
#include "core/map/map_snapshot.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// One step of a mirrored map, put together from its parts on a copy of the map before it. The
/// content of the parts is hostile until checked; their order is not looked at.
///
/// Errors of all: `DataLoss` for damaged leaves and those of objects that are not there, `Internal`
/// for what else makes no sense. The assembly is of no use then.
class MirrorAssembly {
 public:
  /// On top of `before`, which is copied (and shares its volumes).
  explicit MirrorAssembly(const MapSnapshot& before) : map_(before), edits_(&map_) {}

  MirrorAssembly(const MirrorAssembly&) = delete;
  MirrorAssembly& operator=(const MirrorAssembly&) = delete;

  absl::Status TakeSnapshot(const v1::SnapshotChunk& chunk);
  absl::Status TakeDelta(const v1::DeltaFragment& delta);
  absl::Status TakeEvents(const v1::EventBatch& batch);

  /// The whole step. To be called once, last.
  MirrorStep Finish(const WatchStep& step);

 private:
  absl::Status TakeObject(const v1::Object& message);
  absl::Status TakeLeaf(const v1::PackedLeaf& leaf);

  MapSnapshot map_;
  MapEdits edits_;
  std::set<ObjectId> objects_;
  std::vector<LeafKey> leaves_;  ///< In the order they came.
  std::vector<NumberedEvent> events_;
};

}  // namespace steadymap

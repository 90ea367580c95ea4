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

/// Assembles one step of a mirrored map from its parts, on a copy of the previous map. The content
/// of the parts is untrusted until checked; their order is not checked here.
///
/// Errors of all functions: `DataLoss` for damaged leaves and leaves of missing objects, `Internal`
/// for other invalid content. The assembly must be discarded after an error.
class MirrorAssembly {
 public:
  /// Starts from a copy of `before`, which shares its volumes.
  explicit MirrorAssembly(const MapSnapshot& before) : map_(before), edits_(&map_) {}

  MirrorAssembly(const MirrorAssembly&) = delete;
  MirrorAssembly& operator=(const MirrorAssembly&) = delete;

  absl::Status TakeSnapshot(const v1::SnapshotChunk& chunk);
  absl::Status TakeDelta(const v1::DeltaFragment& delta);
  absl::Status TakeEvents(const v1::EventBatch& batch);

  /// Returns the complete step. Call once, after all parts.
  MirrorStep Finish(const WatchStep& step);

 private:
  absl::Status TakeObject(const v1::Object& message);
  absl::Status TakeLeaf(const v1::PackedLeaf& leaf);

  MapSnapshot map_;
  MapEdits edits_;
  std::set<ObjectId> objects_;
  std::vector<LeafKey> leaves_;  ///< In order of arrival.
  std::vector<NumberedEvent> events_;
};

}  // namespace steadymap

#include "client/map/mirror_assembly.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <absl/status/statusor.h>
#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "proto/convert_event.h"
#include "proto/convert_geometry.h"
#include "proto/convert_object.h"

namespace steadymap {
namespace {

// A conversion error here is the server's fault, so it must not stay `InvalidArgument`.
absl::Status BadContent(const char* what, std::uint64_t number, const absl::Status& status) {
  return MakeError(
      absl::StatusCode::kInternal,
      reason::kInternal,
      absl::StrCat(
          "the server sent an invalid ", what, " with number ", number, ": ", status.message()));
}

}  // namespace

absl::Status MirrorAssembly::TakeSnapshot(const v1::SnapshotChunk& chunk) {
  absl::Status status;
  for (const v1::Object& object : chunk.objects()) status.Update(TakeObject(object));
  for (const v1::PackedLeaf& leaf : chunk.leaves()) {
    if (!status.ok()) break;
    status = TakeLeaf(leaf);
  }
  return status;
}

absl::Status MirrorAssembly::TakeDelta(const v1::DeltaFragment& delta) {
  for (const std::uint64_t id : delta.removed_object_ids()) {
    edits_.RemoveObject(ObjectId(id));
    objects_.insert(ObjectId(id));
  }
  absl::Status status;
  for (const v1::Object& object : delta.objects()) status.Update(TakeObject(object));
  for (const v1::PackedLeaf& leaf : delta.leaves()) {
    if (!status.ok()) break;
    status = TakeLeaf(leaf);
  }
  return status;
}

absl::Status MirrorAssembly::TakeObject(const v1::Object& message) {
  const absl::StatusOr<ObjectState> state = FromProto(message);
  if (!state.ok()) return BadContent("object", message.id(), state.status());
  edits_.SetState(*state);
  objects_.insert(state->id);
  map_.newest_object = std::max(map_.newest_object, state->id);
  return absl::OkStatus();
}

absl::Status MirrorAssembly::TakeLeaf(const v1::PackedLeaf& leaf) {
  const LeafOrigin origin{leaf.origin_x(), leaf.origin_y(), leaf.origin_z()};
  if (origin != LeafOf(origin.x, origin.y, origin.z)) {
    return MakeError(absl::StatusCode::kInternal,
                     reason::kInternal,
                     "the server sent a leaf whose origin is not a multiple of 8");
  }
  const LeafKey key{ObjectId(leaf.object_id()), origin};
  absl::Status status =
      leaf.is_patch() ? edits_.PatchLeaf(key, leaf.packed()) : edits_.StoreLeaf(key, leaf.packed());
  if (status.ok()) leaves_.push_back(key);
  return status;
}

absl::Status MirrorAssembly::TakeEvents(const v1::EventBatch& batch) {
  for (const v1::ObjectEvent& message : batch.events()) {
    absl::StatusOr<ObjectEvent> event = FromProto(message);
    if (!event.ok()) return BadContent("event", message.number(), event.status());
    events_.push_back({EventNumber(message.number()), *std::move(event)});
  }
  return absl::OkStatus();
}

MirrorStep MirrorAssembly::Finish(const WatchStep& step) {
  edits_.Finish();
  map_.revision = step.revision;
  map_.last_capture_time = step.last_capture_time.value_or(Timestamp());
  // Drops leaves of objects that were removed after the leaves had arrived.
  std::erase_if(leaves_, [this](const LeafKey& key) {
    return key.object != kBackgroundId && !map_.objects.contains(key.object);
  });
  std::sort(leaves_.begin(), leaves_.end());
  leaves_.erase(std::unique(leaves_.begin(), leaves_.end()), leaves_.end());
  return {.previous_revision = step.previous_revision,
          .commits = step.commits,
          .is_snapshot = step.is_snapshot,
          .objects = {objects_.begin(), objects_.end()},
          .leaves = std::move(leaves_),
          .events = std::move(events_),
          .resume_token = step.resume_token,
          .map = std::make_shared<const MapSnapshot>(std::move(map_))};
}

}  // namespace steadymap

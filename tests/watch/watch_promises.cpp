#include "tests/watch/watch_promises.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "proto/convert_event.h"
#include "proto/convert_geometry.h"
#include "tests/support/packed_leaf.h"

namespace steadymap {
namespace {

LeafKey KeyOf(const v1::PackedLeaf& leaf) {
  return {ObjectId(leaf.object_id()), {leaf.origin_x(), leaf.origin_y(), leaf.origin_z()}};
}

/// Names the first difference between the actual and the expected content.
template <typename Map>
std::string FirstDifference(const Map& has, const Map& ought) {
  for (const auto& [key, value] : ought) {
    const auto found = has.find(key);
    if (found == has.end()) return "one is missing";
    if (found->second != value) return "one is not what the map had";
  }
  return "one is there that should not be";
}

}  // namespace

WatchPromises::WatchPromises(const MapFilter& filter,
                             const MapHistory* history,
                             const VoxelScale& scale)
    : filter_(filter), history_(history), scale_(scale), replay_(history, scale) {}

void WatchPromises::BeginStream(Begin begin) {
  within_step_ = begin == Begin::kWithinStep;
  if (within_step_) return;
  begin_ = begin;
  if (begin_ != Begin::kResumed) {
    // A new watch: earlier content does not count.
    progress_.reset();
    replay_ = MapReplay(history_, scale_);
    content_ = {};
    revision_ = 0;
    settled_event_ = 0;
  }
  expects_snapshot_ = begin_ == Begin::kSnapshot;
  may_repeat_ = begin_ == Begin::kResumed;
  VoidStep();
}

void WatchPromises::VoidStep() {
  last_event_ = settled_event_;
  next_ = content_;
  step_revision_ = 0;
  fragments_ = 0;
  next_fragment_ = 1;
  events_.clear();
  part_token_.clear();
}

void WatchPromises::Take(const v1::WatchMapResponse& message) {
  if (message.has_snapshot()) part_token_ = message.snapshot().resume_token();
  if (message.has_delta()) part_token_ = message.delta().resume_token();
  if (message.has_events()) part_token_ = message.events().resume_token();
  switch (message.kind_case()) {
    case v1::WatchMapResponse::kCreated:
      return TakeCreated(message.created());
    case v1::WatchMapResponse::kSnapshot:
      return TakeSnapshot(message.snapshot());
    case v1::WatchMapResponse::kDelta:
      return TakeDelta(message.delta());
    case v1::WatchMapResponse::kEvents:
      return TakeEvents(message.events());
    case v1::WatchMapResponse::kProgress:
      return TakeProgress(message.progress());
    case v1::WatchMapResponse::kResync:
      return TakeResync(message.resync());
    default:
      return;
  }
}

/// Checks that an interrupted step continues, or is void: then a new snapshot follows.
void WatchPromises::TakeWithinStep(const v1::WatchCreated& created) {
  within_step_ = false;
  const std::uint64_t due = expects_snapshot_ ? step_revision_ : revision_;
  if (created.continues_step()) {
    ++continued_;
    if (created.revision() != due) {
      Break("Resumable", absl::StrCat("within the step at ", due, " at ", created.revision()));
    }
    return;
  }
  VoidStep();
  if (expects_snapshot_) {
    next_ = {};
  } else if (created.revision() != due && created.revision() != 0) {
    Break("Resumable", absl::StrCat("behind ", due, " the stream began at ", created.revision()));
  }
}

void WatchPromises::TakeCreated(const v1::WatchCreated& created) {
  if (within_step_) return TakeWithinStep(created);
  if (created.continues_step()) Break("Resumable", "within a step, which nobody asked for");
  if (begin_ == Begin::kNow) {
    revision_ = created.revision();
    if (!replay_.GoTo(Revision(revision_))) Break("Bookmarkable", "began at no revision");
    replay_.TakeEvents();
  }
  // The stream starts at the token's revision, unless a resync follows.
  if (begin_ == Begin::kResumed && created.revision() != revision_ && created.revision() != 0) {
    Break("Resumable",
          absl::StrCat("behind ", revision_, " the stream began at ", created.revision()));
  }
}

void WatchPromises::TakeResync(const v1::WatchResync& resync) {
  ++resyncs_;
  if (step_revision_ != 0) Break("Atomic", "a resync in the middle of a step");
  if (resync.revision() < revision_) {
    Break("Ordered", absl::StrCat("resync from ", revision_, " back to ", resync.revision()));
  }
  expects_snapshot_ = true;
  next_ = {};
  part_token_.clear();
}

void WatchPromises::TakeSnapshot(const v1::SnapshotChunk& chunk) {
  if (!expects_snapshot_) Break("Reliable", "a snapshot that nobody asked for");
  if (step_revision_ != 0 && step_revision_ != chunk.revision()) {
    Break("Atomic", "a snapshot of two revisions");
  }
  step_revision_ = chunk.revision();
  Put(chunk.objects(), chunk.leaves());
}

void WatchPromises::TakeDelta(const v1::DeltaFragment& fragment) {
  if (fragment.previous_revision() != revision_) {
    Break("Reliable",
          absl::StrCat("a step from ", fragment.previous_revision(), " at ", revision_));
  }
  if (fragment.revision() <= revision_) {
    Break("Ordered", absl::StrCat(fragment.revision(), " after ", revision_));
  }
  if (fragment.fragment() != next_fragment_ ||
      (fragments_ != 0 &&
       (fragments_ != fragment.fragments() || step_revision_ != fragment.revision()))) {
    Break("Atomic",
          absl::StrCat("fragment ", fragment.fragment(), " where ", next_fragment_, " is due"));
  }
  if (fragment.fragment() == 1 && fragment.commits() > 1) ++jumps_;
  fragments_ = fragment.fragments();
  next_fragment_ = fragment.fragment() + 1;
  step_revision_ = fragment.revision();
  for (const std::uint64_t id : fragment.removed_object_ids()) {
    next_.objects.erase(ObjectId(id));
    std::erase_if(next_.leaves,
                  [&](const auto& leaf) { return leaf.first.object == ObjectId(id); });
  }
  Put(fragment.objects(), fragment.leaves());
}

template <typename Objects, typename Leaves>
void WatchPromises::Put(const Objects& objects, const Leaves& leaves) {
  for (const v1::Object& object : objects) {
    next_.objects[ObjectId(object.id())] = object.SerializeAsString();
  }
  for (const v1::PackedLeaf& leaf : leaves) {
    const LeafKey key = KeyOf(leaf);
    if (key.object != kBackgroundId && !next_.objects.contains(key.object)) {
      Break("Filtered", absl::StrCat("a leaf of object ", key.object.value(), " without it"));
    }
    std::string& known = next_.leaves[key];
    const std::optional<std::string> packed = testing::TakePackedLeaf(leaf, known);
    if (!packed) Break("Reliable", "a patch of a leaf that the watcher does not have");
    known = packed.value_or(std::string());
    if (known.empty()) next_.leaves.erase(key);
    if (leaf.is_patch()) ++patches_;
  }
}

void WatchPromises::TakeEvents(const v1::EventBatch& batch) {
  if (next_fragment_ != fragments_ + 1) Break("Atomic", "events before the delta was whole");
  if (step_revision_ != 0 && step_revision_ != batch.revision()) {
    Break("Atomic", "events of another step");
  }
  step_revision_ = batch.revision();
  for (const v1::ObjectEvent& event : batch.events()) {
    if (event.number() == last_event_) {
      Break("Unique", absl::StrCat("event ", event.number(), " twice"));
    } else if (event.number() < last_event_) {
      Break("Ordered", absl::StrCat("event ", event.number(), " after ", last_event_));
    }
    if (event.revision() <= revision_ || event.revision() > batch.revision()) {
      Break("Atomic",
            absl::StrCat("event ",
                         event.number(),
                         " of revision ",
                         event.revision(),
                         " in the step from ",
                         revision_,
                         " to ",
                         batch.revision()));
    }
    last_event_ = event.number();
    events_.push_back(event);
  }
}

void WatchPromises::TakeProgress(const v1::WatchProgress& progress) {
  if (fragments_ != 0 && next_fragment_ != fragments_ + 1) {
    Break("Atomic",
          absl::StrCat("a token after ", next_fragment_ - 1, " of ", fragments_, " fragments"));
  }
  if (step_revision_ != 0 && step_revision_ != progress.revision()) {
    Break("Bookmarkable",
          absl::StrCat("progress ", progress.revision(), ", data of ", step_revision_));
  }
  const bool may_repeat = std::exchange(may_repeat_, false) && step_revision_ == 0;
  if (!expects_snapshot_ && progress.revision() == revision_ && progress_ && !may_repeat) {
    Break("Unique", absl::StrCat("revision ", revision_, " twice"));
  } else if (progress.revision() < revision_) {
    Break("Ordered", absl::StrCat(progress.revision(), " after ", revision_));
  }
  if (!replay_.GoTo(Revision(progress.revision()))) {
    Break("Bookmarkable", absl::StrCat("revision ", progress.revision(), " was never durable"));
  } else {
    if (begin_ != Begin::kNow) CheckShown(replay_.Shown(filter_));
    CheckEvents();
    CheckTime(progress);
  }
  revision_ = progress.revision();
  content_ = next_;
  progress_ = progress;
  expects_snapshot_ = false;
  step_revision_ = 0;
  fragments_ = 0;
  next_fragment_ = 1;
  events_told_ += events_.size();
  settled_event_ = last_event_;
  events_.clear();
  part_token_.clear();
  ++steps_;
}

void WatchPromises::CheckShown(const WatchedContent& truth) {
  for (const auto& [id, object] : next_.objects) {
    if (!truth.objects.contains(id)) {
      Break("Filtered", absl::StrCat("object ", id.value(), " is not shown"));
    }
  }
  if (next_ == truth) return;
  const bool objects_differ = next_.objects != truth.objects;
  Break("Bookmarkable",
        objects_differ
            ? absl::StrCat("of the objects ", FirstDifference(next_.objects, truth.objects))
            : absl::StrCat("of the leaves ", FirstDifference(next_.leaves, truth.leaves)));
}

/// The events of the step must equal the events of the history that pass the filter.
void WatchPromises::CheckEvents() {
  std::vector<std::string> due;
  for (const MapReplay::NumberedEvent& numbered : replay_.TakeEvents()) {
    if (filter_.events && filter_.Shows(numbered.event)) {
      due.push_back(ToProto(numbered.number, numbered.event).SerializeAsString());
    }
  }
  // A snapshot contains no events.
  if (expects_snapshot_) return;
  std::vector<std::string> told;
  for (const v1::ObjectEvent& event : events_) {
    told.push_back(event.SerializeAsString());
    const absl::StatusOr<ObjectEvent> read = FromProto(event);
    if (!read.ok() || !filter_.events || !filter_.Shows(*read)) {
      Break("Filtered", absl::StrCat("event ", event.number(), " does not pass"));
    }
  }
  if (told != due) {
    Break("Reliable", absl::StrCat(told.size(), " events were told, ", due.size(), " were due"));
  }
}

void WatchPromises::CheckTime(const v1::WatchProgress& progress) {
  if (progress.revision() == 0 && !progress.has_last_capture_time()) return;
  const absl::StatusOr<Timestamp> time = FromProto(progress.last_capture_time());
  if (!time.ok() || *time != replay_.last_capture_time()) {
    Break("Bookmarkable", absl::StrCat("the capture time is not that of ", progress.revision()));
  }
}

void WatchPromises::Break(const char* promise, const std::string& what) {
  if (broken_.size() < 20) broken_.push_back(absl::StrCat(promise, ": ", what));
}

}  // namespace steadymap

#include "server/watch/watch_messages.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "core/volume/tsdf_codec.h"
#include "proto/convert_event.h"
#include "proto/convert_geometry.h"
#include "proto/convert_object.h"
#include "server/rpc/request_reader.h"

namespace steadymap {
namespace {

// Maximum size of a packed leaf with colour and its key, and of an object id.
constexpr std::size_t kMaxLeafBytes = 4608;
constexpr std::size_t kMaxIdBytes = 10;

// Bytes for the other fields of a message.
constexpr std::size_t kMessageMarginBytes = 512;

constexpr std::size_t kEventsPerMessage = 200;

// Messages of a step with at most this many leaves and objects are kept in memory, about 1 MB.
constexpr std::size_t kMaxKeptValues = 3000;

// A step below both limits is sent again as a whole after an interruption; its messages have no
// tokens.
constexpr std::size_t kMinResumableBytes = std::size_t{64} << 10;
constexpr std::size_t kMinResumableMessages = 3;

}  // namespace

WatchMessages::WatchMessages(Source source, StepPlan step, const Cancellation& cancellation)
    : source_(std::move(source)), step_(std::move(step)) {
  const std::size_t bytes = PlanFragments(cancellation);
  // Events before a snapshot are not sent.
  if (source_.filter.events && step_.from) {
    const std::uint64_t events =
        source_.after.last_event.value() - source_.key.before.last_event.value();
    event_pages_ = (events + kEventsPerMessage - 1) / kEventsPerMessage;
  }
  keeps_ = step_.leaves.size() + step_.objects.size() + step_.removed.size() <= kMaxKeptValues;
  if (keeps_) kept_.resize(count());
  is_resumable_ = bytes > kMinResumableBytes || count() > kMinResumableMessages;
}

/// Assigns objects and leaves to messages by their maximum size, so that the number of messages is
/// known before the first is made. Returns the maximum size of all data in bytes.
std::size_t WatchMessages::PlanFragments(const Cancellation& cancellation) {
  if (step_.IsEmpty()) return 0;
  const std::size_t room = source_.key.max_message_bytes - kMessageMarginBytes;
  std::size_t bytes = 0;
  std::size_t all_bytes = 0;
  fragments_.emplace_back();
  const auto make_room = [&](std::size_t needed) {
    if (bytes > 0 && bytes + needed > room) {
      const Fragment& full = fragments_.back();
      fragments_.push_back({full.last_removed,
                            full.last_removed,
                            full.last_object,
                            full.last_object,
                            full.last_leaf,
                            full.last_leaf});
      bytes = 0;
    }
    bytes += needed;
    all_bytes += needed;
  };
  for (std::size_t i = 0; i < step_.removed.size(); ++i) {
    make_room(kMaxIdBytes);
    fragments_.back().last_removed = i + 1;
  }
  for (std::size_t i = 0; i < step_.objects.size(); ++i) {
    if (cancellation.IsCancelled()) return 0;
    make_room(kMaxIdBytes + ToProto(*step_.snapshot->objects.at(step_.objects[i])).ByteSizeLong());
    fragments_.back().last_object = i + 1;
  }
  for (std::size_t i = 0; i < step_.leaves.size(); ++i) {
    make_room(kMaxLeafBytes);
    fragments_.back().last_leaf = i + 1;
  }
  return all_bytes;
}

absl::StatusOr<std::optional<grpc::ByteBuffer>> WatchMessages::At(std::size_t place) {
  if (!keeps_) return Make(place);
  // A second watcher waits here until the first has made the message.
  const absl::MutexLock lock(&mutex_);
  if (!kept_[place]) {
    absl::StatusOr<std::optional<grpc::ByteBuffer>> made = Make(place);
    if (!made.ok()) return made.status();
    kept_[place] = *std::move(made);
  }
  return *kept_[place];
}

absl::StatusOr<std::optional<grpc::ByteBuffer>> WatchMessages::Make(std::size_t place) const {
  if (place < fragments_.size()) return ToByteBuffer(MakeFragment(place));
  if (place + 1 == count()) return ToByteBuffer(MakeProgress());
  const absl::StatusOr<v1::WatchMapResponse> events = MakeEvents(place - fragments_.size());
  if (!events.ok()) return events.status();
  if (events->events().events().empty()) return std::optional<grpc::ByteBuffer>();
  return ToByteBuffer(*events);
}

v1::WatchMapResponse WatchMessages::MakeFragment(std::size_t place) const {
  const Fragment& fragment = fragments_[place];
  const MapSnapshot& map = *step_.snapshot;
  v1::WatchMapResponse message;
  const auto fill = [&](auto* part) {
    part->set_revision(map.revision.value());
    if (is_resumable_) part->set_resume_token(TokenBehind(place));
    for (std::size_t i = fragment.first_object; i < fragment.last_object; ++i) {
      *part->add_objects() = ToProto(*map.objects.at(step_.objects[i]));
    }
    for (std::size_t i = fragment.first_leaf; i < fragment.last_leaf; ++i) {
      AddLeaf(step_.leaves[i], part->mutable_leaves());
    }
  };
  if (!step_.from) {
    fill(message.mutable_snapshot());
    return message;
  }
  v1::DeltaFragment* delta = message.mutable_delta();
  fill(delta);
  delta->set_previous_revision(step_.from->value());
  delta->set_commits(step_.commits);
  delta->set_fragment(static_cast<std::uint32_t>(place + 1));
  delta->set_fragments(static_cast<std::uint32_t>(fragments_.size()));
  for (std::size_t i = fragment.first_removed; i < fragment.last_removed; ++i) {
    delta->add_removed_object_ids(step_.removed[i].value());
  }
  return message;
}

void WatchMessages::AddLeaf(const LeafKey& key,
                            google::protobuf::RepeatedPtrField<v1::PackedLeaf>* leaves) const {
  const std::optional<LeafView> patch = step_.FindPatch(key);
  // Voxels that changed and changed back are not sent.
  if (patch && patch->observed == LeafMask{}) return;
  v1::PackedLeaf* const leaf = leaves->Add();
  leaf->set_object_id(key.object.value());
  leaf->set_origin_x(key.origin.x);
  leaf->set_origin_y(key.origin.y);
  leaf->set_origin_z(key.origin.z);
  leaf->set_packed(PackLeaf(patch ? *patch : FindLeaf(*step_.snapshot, key)));
  leaf->set_is_patch(patch.has_value());
}

absl::StatusOr<v1::WatchMapResponse> WatchMessages::MakeEvents(std::size_t page) const {
  const EventNumber first(source_.key.before.last_event.value() + 1 + page * kEventsPerMessage);
  const EventNumber last(
      std::min(first.value() + kEventsPerMessage - 1, source_.after.last_event.value()));
  const absl::StatusOr<std::vector<StoredEvent>> events = source_.store->ReadEvents(
      source_.key.scope.map, first, static_cast<std::size_t>(last.value() - first.value()) + 1);
  if (!events.ok()) return events.status();
  if (events->empty() || events->front().number != first || events->back().number != last) {
    return MakeError(absl::StatusCode::kAborted,
                     reason::kSlowConsumer,
                     absl::StrCat("events from number ", first.value(), " are no longer stored"));
  }
  v1::WatchMapResponse message;
  v1::EventBatch* batch = message.mutable_events();
  batch->set_revision(source_.after.revision.value());
  if (is_resumable_) batch->set_resume_token(TokenBehind(fragments_.size() + page));
  for (const StoredEvent& stored : *events) {
    if (source_.filter.Shows(stored.event)) {
      *batch->add_events() = ToProto(stored.number, stored.event);
    }
  }
  return message;
}

std::string WatchMessages::TokenBehind(std::size_t place) const {
  return MakeStepToken(source_.key, place + 1);
}

v1::WatchMapResponse WatchMessages::MakeProgress() const {
  v1::WatchMapResponse message;
  v1::WatchProgress* progress = message.mutable_progress();
  progress->set_revision(source_.after.revision.value());
  progress->set_resume_token(MakeResumeToken(source_.key.scope, source_.after));
  if (const MapSnapshot& map = *step_.snapshot; map.last_capture_time != Timestamp()) {
    *progress->mutable_last_capture_time() = ToProto(map.last_capture_time);
  }
  return message;
}

}  // namespace steadymap

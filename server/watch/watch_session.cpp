#include "server/watch/watch_session.h"

#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "proto/convert_watch.h"
#include "server/rpc/request_reader.h"
#include "server/upload/upload_registry.h"

namespace steadymap {
namespace {

constexpr std::size_t kDefaultMessageBytes = std::size_t{1} << 20;
constexpr std::size_t kSmallestMessageBytes = std::size_t{64} << 10;
constexpr std::size_t kLargestMessageBytes = std::size_t{4} << 20;

// About the duration of a server restart.
constexpr int kReconnectAfterSeconds = 1;

absl::StatusOr<std::size_t> ReadMessageLimit(std::size_t asked) {
  if (asked == 0) return kDefaultMessageBytes;
  if (asked >= kSmallestMessageBytes && asked <= kLargestMessageBytes) return asked;
  return InvalidField(reason::kBadValue,
                      "max_message_bytes",
                      absl::StrCat("max_message_bytes must lie in [",
                                   kSmallestMessageBytes,
                                   ", ",
                                   kLargestMessageBytes,
                                   "], got ",
                                   asked));
}

absl::Status NoLeavesToPatch() {
  return InvalidField(reason::kBadValue,
                      "takes_patches",
                      "patches need a start with a snapshot: this watch has no leaves to patch");
}

grpc::ByteBuffer MakeResync(Revision revision, const std::string& why) {
  v1::WatchMapResponse message;
  message.mutable_resync()->set_revision(revision.value());
  message.mutable_resync()->set_reason(why);
  return ToByteBuffer(message);
}

grpc::ByteBuffer MakeGoodbye() {
  v1::WatchMapResponse message;
  message.mutable_goodbye()->mutable_reconnect_after()->set_seconds(kReconnectAfterSeconds);
  return ToByteBuffer(message);
}

}  // namespace

WatchSession::WatchSession(const MapDirectory* maps,
                           WatchHub* hub,
                           v1::WatchMapRequest request,
                           Cancellation cancellation)
    : maps_(maps),
      hub_(hub),
      request_(std::move(request)),
      cancellation_(std::move(cancellation)) {}

absl::Status WatchSession::ReadRequest() {
  absl::StatusOr<std::shared_ptr<MapRuntime>> map = maps_->Find(request_.map(), "map");
  if (!map.ok()) return map.status();
  absl::StatusOr<MapFilter> filter = FromProto(request_.filter());
  if (!filter.ok()) return WithFieldPrefix(filter.status(), "filter");
  const absl::StatusOr<std::size_t> limit = ReadMessageLimit(request_.max_message_bytes());
  if (!limit.ok()) return limit.status();
  map_ = *std::move(map);
  filter_ = *std::move(filter);
  max_message_bytes_ = *limit;
  return absl::OkStatus();
}

absl::StatusOr<WatchSession::Message> WatchSession::Begin() {
  scope_ = {
      map_->key(), map_->name().ToString(), map_->record().incarnation, FingerprintOf(filter_)};
  absl::Status status = map_->CheckReads();
  if (status.ok()) status = ChooseStart(map_->published());
  if (!status.ok()) return status;
  return MakeCreated();
}

absl::Status WatchSession::ChooseStart(const PublishedRevision& newest) {
  if (!request_.resume_token().empty()) return ResumeBehindToken(newest);
  switch (request_.start()) {
    case v1::WATCH_START_NOW:
      if (request_.takes_patches()) return NoLeavesToPatch();
      position_ = {newest.commit.revision, newest.snapshot->last_event, newest.commit.hash, false};
      SendEmptyStep(newest);
      return absl::OkStatus();
    case v1::WATCH_START_SNAPSHOT_THEN_FOLLOW:
      BeginSnapshot(newest);
      return absl::OkStatus();
    default:
      return InvalidField(reason::kBadValue, "start", "a watch needs `start` or a `resume_token`");
  }
}

void WatchSession::BeginSnapshot(const PublishedRevision& newest) {
  position_.revision = newest.commit.revision;
  next_snapshot_ = newest;
}

/// Sends an empty step to the current position: a new watcher receives a token before the first
/// change, and a resumed watcher is informed that it is up to date.
void WatchSession::SendEmptyStep(const PublishedRevision& newest) {
  StepPlan nothing;
  nothing.from = newest.commit.revision;
  nothing.shown = ShownBy(filter_, *newest.snapshot);
  nothing.snapshot = newest.snapshot;
  step_ = std::make_shared<WatchMessages>(
      WatchMessages::Source{
          nullptr, filter_, {scope_, position_, position_.commit(), max_message_bytes_}, position_},
      std::move(nothing));
}

absl::Status WatchSession::ResumeBehindToken(const PublishedRevision& newest) {
  if (request_.start() != v1::WATCH_START_UNSPECIFIED) {
    return InvalidField(
        reason::kBadValue, "start", "`start` must not be set together with `resume_token`");
  }
  const absl::StatusOr<ResumeToken> token = ReadResumeToken(scope_, request_.resume_token());
  if (!token.ok()) return token.status();
  const WatchPosition& position = token->position;
  if (!token->fit.ok()) {
    gap_ = token->fit;
  } else if (request_.takes_patches() && !position.has_leaves) {
    return NoLeavesToPatch();
  } else if (position.revision > newest.commit.revision) {
    gap_ = MakeError(absl::StatusCode::kOutOfRange,
                     reason::kRevisionInFuture,
                     absl::StrCat("the resume token is of revision ",
                                  position.revision.value(),
                                  ", which is newer than the map's revision ",
                                  newest.commit.revision.value()),
                     "resume_token");
  } else if (position.revision == newest.commit.revision && position.commit() != newest.commit) {
    gap_ = MakeError(absl::StatusCode::kOutOfRange,
                     reason::kRevisionCompacted,
                     "the resume token is of another history of the map",
                     "resume_token");
  } else if (token->step && ContinueStep(*token, newest)) {
    continues_step_ = true;
  } else if (token->step && token->step->as_snapshot) {
    BeginSnapshot(newest);
  } else {
    position_ = position;
    if (absl::Status status = TakeFirstStep(newest); !status.ok()) return status;
  }
  return gap_.ok() || request_.resync_if_compacted() ? absl::OkStatus() : gap_;
}

/// Resumes within a step of which the watcher has a part. Returns false if the rest of the step is
/// no longer available.
bool WatchSession::ContinueStep(const ResumeToken& token, const PublishedRevision& newest) {
  const StepKey& key = *token.step;
  // With other options the step has other messages, so the index in the token would be wrong.
  if (key.max_message_bytes != max_message_bytes_ ||
      key.takes_patches != request_.takes_patches()) {
    return false;
  }
  step_ = hub_->FindHeld(key);
  if (step_ == nullptr && key.as_snapshot && key.to == newest.commit) {
    // The map has not changed since, so the same snapshot can be made again.
    next_snapshot_ = newest;
    if (!FindStep(newest).ok()) step_ = nullptr;
    next_snapshot_.reset();
  }
  if (step_ == nullptr || token.place >= step_->count()) {
    step_ = nullptr;
    return false;
  }
  place_ = token.place;
  position_ = token.position;
  if (key.as_snapshot) position_.revision = key.to.revision;
  return true;
}

/// Takes the first step after a valid token, so that `created` is sent only if the watch can
/// continue.
absl::Status WatchSession::TakeFirstStep(const PublishedRevision& newest) {
  if (position_.revision == newest.commit.revision) {
    SendEmptyStep(newest);
    return absl::OkStatus();
  }
  const absl::Status status = FindStep(newest);
  if (absl::IsOutOfRange(status)) gap_ = status;
  return gap_.ok() ? status : absl::OkStatus();
}

absl::StatusOr<WatchSession::Message> WatchSession::Next(bool draining) {
  while (true) {
    absl::StatusOr<Message> message = NextOfStep();
    if (!message.ok() || message->has_value()) return message;
    // Ends the watch of a map that was deleted or cannot be read.
    if (absl::Status status = map_->CheckReads(); !status.ok() && !draining) return status;
    const PublishedRevision newest = map_->published();
    if (!next_snapshot_ && gap_.ok() && newest.commit.revision == position_.revision) break;
    message = TakeStep(newest);
    if (!message.ok() || message->has_value()) return message;
  }
  if (!draining) return Message();
  if (std::exchange(goodbye_sent_, true)) return DrainingError();
  return MakeGoodbye();
}

std::vector<std::shared_ptr<WatchMessages>> WatchSession::StepsInPart() const {
  std::vector<std::shared_ptr<WatchMessages>> steps;
  if (std::shared_ptr<WatchMessages> sent = sent_step_.lock()) steps.push_back(std::move(sent));
  if (step_ != nullptr && place_ > 0 && step_->is_resumable()) steps.push_back(step_);
  return steps;
}

/// Returns the next message of the current step. Returns none and resets the step at its end.
absl::StatusOr<WatchSession::Message> WatchSession::NextOfStep() {
  while (step_ != nullptr) {
    if (place_ == step_->count()) {
      if (step_->is_resumable()) sent_step_ = step_;
      position_ = step_->after();
      shown_ = step_->shown();
      step_ = nullptr;
      break;
    }
    absl::StatusOr<Message> message = step_->At(place_++);
    if (!message.ok() || message->has_value()) return message;
  }
  return Message();
}

/// Starts the step to `newest`, or returns a message that must be sent first.
absl::StatusOr<WatchSession::Message> WatchSession::TakeStep(const PublishedRevision& newest) {
  if (!gap_.ok()) return HandleGap(std::exchange(gap_, absl::OkStatus()), newest);
  const absl::Status status = FindStep(newest);
  if (absl::IsOutOfRange(status)) return HandleGap(status, newest);
  if (!status.ok()) return status;
  return Message();
}

absl::Status WatchSession::FindStep(const PublishedRevision& newest) {
  WatchHub::StepRequest wanted{scope_,
                               filter_,
                               max_message_bytes_,
                               request_.takes_patches(),
                               false,
                               position_,
                               shown_,
                               newest,
                               cancellation_};
  if (next_snapshot_) {
    wanted.as_snapshot = true;
    wanted.before = {};
    wanted.shown = nullptr;
    wanted.to = *next_snapshot_;
  }
  absl::StatusOr<std::shared_ptr<WatchMessages>> step = hub_->FindStep(wanted);
  if (!step.ok()) return step.status();
  step_ = *std::move(step);
  place_ = 0;
  next_snapshot_.reset();
  return absl::OkStatus();
}

/// Handles a missing history between the watcher and the map: resynchronises with a snapshot if the
/// client requested that, else returns the error.
absl::StatusOr<WatchSession::Message> WatchSession::HandleGap(const absl::Status& gap,
                                                              const PublishedRevision& newest) {
  if (request_.resync_if_compacted()) {
    next_snapshot_ = newest;
    return MakeResync(newest.commit.revision, ReasonOf(gap));
  }
  return MakeError(
      absl::StatusCode::kAborted,
      reason::kSlowConsumer,
      absl::StrCat(
          "the watcher is too far behind, and the history that it needs is no longer stored: ",
          std::string(gap.message())));
}

grpc::ByteBuffer WatchSession::MakeCreated() const {
  const MapConfig& config = map_->record().config;
  v1::WatchMapResponse message;
  v1::WatchCreated* created = message.mutable_created();
  created->set_revision(position_.revision.value());
  created->set_voxel_size_m(config.voxel_size_m);
  created->set_truncation_m(config.truncation_m);
  created->set_incarnation(scope_.incarnation);
  created->set_continues_step(continues_step_);
  return ToByteBuffer(message);
}

}  // namespace steadymap

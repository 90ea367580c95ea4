#include "server/watch_stream.h"

#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/server_context.h>
#include <spdlog/spdlog.h>

#include "core/error.h"
#include "proto/convert_watch.h"
#include "proto/grpc_status.h"
#include "server/pool_call.h"
#include "server/upload_roster.h"

namespace steadymap {
namespace {

constexpr std::size_t kDefaultMessageBytes = std::size_t{1} << 20;
constexpr std::size_t kMinMessageBytes = std::size_t{64} << 10;
constexpr std::size_t kMaxMessageBytes = std::size_t{4} << 20;

// A restart takes about that long.
constexpr int kReconnectAfterSeconds = 1;

absl::StatusOr<std::size_t> ReadMessageLimit(std::size_t asked) {
  if (asked == 0) return kDefaultMessageBytes;
  if (asked >= kMinMessageBytes && asked <= kMaxMessageBytes) return asked;
  return InvalidField(reason::kBadValue,
                      "max_message_bytes",
                      absl::StrCat("max_message_bytes must lie in [",
                                   kMinMessageBytes,
                                   ", ",
                                   kMaxMessageBytes,
                                   "], got ",
                                   asked));
}

grpc::ByteBuffer MakeResync(Revision revision, const std::string& why) {
  v1::WatchMapResponse message;
  message.mutable_resync()->set_revision(revision.value());
  message.mutable_resync()->set_reason(why);
  return Serialize(message);
}

grpc::ByteBuffer MakeGoodbye() {
  v1::WatchMapResponse message;
  message.mutable_goodbye()->mutable_reconnect_after()->set_seconds(kReconnectAfterSeconds);
  return Serialize(message);
}

}  // namespace

/// What gRPC holds: passes its reports on.
class WatchStream::Reactor final : public GrpcReactor {
 public:
  explicit Reactor(std::shared_ptr<WatchStream> stream) : stream_(std::move(stream)) {}

  void OnWriteDone(bool ok) override { stream_->OnWritten(ok); }

  void OnCancel() override {
    stream_->cancelled_ = true;
    stream_->End(absl::CancelledError("the watcher has gone"));
  }

  void OnDone() override {
    stream_->OnGone();
    delete this;
  }

 private:
  const std::shared_ptr<WatchStream> stream_;
};

WatchStream::GrpcReactor* WatchStream::Start(const Surroundings& surroundings,
                                             grpc::CallbackServerContext* context,
                                             const grpc::ByteBuffer& request) {
  auto stream = std::make_shared<WatchStream>(surroundings, context);
  auto* reactor = new Reactor(stream);
  stream->reactor_ = reactor;
  grpc::ByteBuffer bytes(request);
  stream->is_request_whole_ =
      grpc::SerializationTraits<v1::WatchMapRequest>::Deserialize(&bytes, &stream->request_).ok();
  stream->Schedule();
  return reactor;
}

WatchStream::WatchStream(const Surroundings& surroundings, grpc::CallbackServerContext* context)
    : surroundings_(surroundings), context_(context) {}

void WatchStream::Wake() { Schedule(); }

void WatchStream::Drain() {
  {
    const absl::MutexLock lock(&mutex_);
    draining_ = true;
  }
  Schedule();
}

void WatchStream::End(const absl::Status& status) {
  {
    const absl::MutexLock lock(&mutex_);
    if (!end_) end_ = status;
  }
  Schedule();
}

void WatchStream::Cancel() {
  const absl::MutexLock lock(&mutex_);
  if (context_ != nullptr) context_->TryCancel();
}

Revision WatchStream::revision() const {
  const absl::MutexLock lock(&mutex_);
  return revision_;
}

absl::Time WatchStream::sending_since() const {
  const absl::MutexLock lock(&mutex_);
  return sending_since_;
}

void WatchStream::OnWritten(bool ok) {
  {
    const absl::MutexLock lock(&mutex_);
    sending_since_ = absl::InfiniteFuture();
    if (!ok && !end_) end_ = absl::CancelledError("the watcher has gone");
    activity_ = Activity::kAdvancing;
  }
  Submit();
}

void WatchStream::OnGone() {
  bool entered = false;
  absl::Status status;
  {
    const absl::MutexLock lock(&mutex_);
    context_ = nullptr;
    entered = std::exchange(entered_, false);
    if (end_) status = *end_;
  }
  if (!entered) return;
  surroundings_.hub->Leave(map_->key(), shared_from_this());
  spdlog::debug("map {}: a watch ended behind revision {}: {}",
                map_->name().ToString(),
                position_.revision.value(),
                status.ToString());
}

/// Sees to it that somebody looks at the stream after this call.
void WatchStream::Schedule() {
  {
    const absl::MutexLock lock(&mutex_);
    woken_ = true;
    if (activity_ != Activity::kIdle) return;
    activity_ = Activity::kAdvancing;
  }
  Submit();
}

void WatchStream::Submit() {
  // Each stream waits once at most. In turn: nobody may fall behind because others are served
  // again.
  if (!surroundings_.pool->TrySubmit([self = shared_from_this()] { self->Advance(); })) {
    Finish(PoolFullError());
  }
}

void WatchStream::Advance() {
  while (true) {
    bool draining = false;
    std::optional<absl::Status> end;
    {
      const absl::MutexLock lock(&mutex_);
      woken_ = false;
      draining = draining_;
      end = end_;
    }
    if (end) return Finish(*end);
    absl::StatusOr<Message> message = Message();
    const absl::Status status = RunGuarded([this, draining, &message] {
      message = Next(draining);
      return message.status();
    });
    const absl::MutexLock lock(&mutex_);
    revision_ = position_.revision;
    if (!status.ok()) {
      if (!end_) end_ = status;
    } else if (message->has_value()) {
      outgoing_ = **std::move(message);
      activity_ = Activity::kWriting;
      sending_since_ = absl::Now();
      break;
    } else if (!woken_ && !end_) {
      activity_ = Activity::kIdle;
      return;
    }
  }
  reactor_->StartWrite(&outgoing_);
}

void WatchStream::Finish(const absl::Status& status) {
  {
    const absl::MutexLock lock(&mutex_);
    activity_ = Activity::kFinished;
  }
  reactor_->Finish(ToGrpcStatus(status));
}

absl::Status WatchStream::Open() {
  if (!is_request_whole_) {
    return absl::InvalidArgumentError("the request is no WatchMapRequest");
  }
  absl::StatusOr<std::shared_ptr<MapRuntime>> map = surroundings_.maps->Find(request_.map(), "map");
  if (!map.ok()) return map.status();
  absl::StatusOr<MapFilter> filter = FromProto(request_.filter());
  if (!filter.ok()) return WithFieldPrefix(filter.status(), "filter");
  const absl::StatusOr<std::size_t> limit = ReadMessageLimit(request_.max_message_bytes());
  if (!limit.ok()) return limit.status();
  map_ = *std::move(map);
  filter_ = *std::move(filter);
  max_message_bytes_ = *limit;
  scope_ = {map_->key(), map_->record().incarnation, FingerprintOf(request_.filter())};
  {
    const absl::MutexLock lock(&mutex_);
    entered_ = true;
  }
  // From here on no commit is missed.
  absl::Status status = surroundings_.hub->Enter(map_->key(), shared_from_this());
  return status.ok() ? ChooseStart(map_->snapshot()) : status;
}

absl::Status WatchStream::ChooseStart(const std::shared_ptr<const MapSnapshot>& snapshot) {
  if (!request_.resume_token().empty()) return ResumeBehindToken(snapshot);
  switch (request_.start()) {
    case v1::WATCH_START_NOW:
      if (request_.takes_patches()) {
        return InvalidField(reason::kBadValue,
                            "takes_patches",
                            "a watch from now on has no leaves that patches could be of");
      }
      BeginFrom(snapshot);
      return absl::OkStatus();
    case v1::WATCH_START_SNAPSHOT_THEN_FOLLOW:
      position_.revision = snapshot->revision;
      next_snapshot_ = snapshot;
      return absl::OkStatus();
    default:
      return InvalidField(reason::kBadValue, "start", "a watch needs `start` or a `resume_token`");
  }
}

/// With an empty step: who is cut off before anything happens has a token to go on behind.
void WatchStream::BeginFrom(const std::shared_ptr<const MapSnapshot>& snapshot) {
  position_ = {snapshot->revision, snapshot->last_event};
  StepPlan nothing;
  nothing.from = snapshot->revision;
  nothing.shown = ShownBy(filter_, *snapshot);
  nothing.snapshot = snapshot;
  step_ = std::make_shared<WatchMessages>(
      WatchMessages::Source{nullptr, scope_, filter_, position_, position_, max_message_bytes_},
      std::move(nothing));
}

absl::Status WatchStream::ResumeBehindToken(const std::shared_ptr<const MapSnapshot>& snapshot) {
  if (request_.start() != v1::WATCH_START_UNSPECIFIED) {
    return InvalidField(
        reason::kBadValue, "start", "`start` must not be set where there is a `resume_token`");
  }
  absl::StatusOr<WatchPosition> position = ReadResumeToken(scope_, request_.resume_token());
  if (absl::IsInvalidArgument(position.status())) return position.status();
  if (!position.ok()) {
    gap_ = position.status();
  } else if (position->revision > snapshot->revision) {
    gap_ = MakeError(absl::StatusCode::kOutOfRange,
                     reason::kRevisionInFuture,
                     absl::StrCat("the resume token is of revision ",
                                  position->revision.value(),
                                  ", the map is at ",
                                  snapshot->revision.value()),
                     "resume_token");
  } else {
    position_ = *position;
    if (position_.revision == snapshot->revision) shown_ = ShownBy(filter_, *snapshot);
  }
  return gap_.ok() || request_.resync_if_compacted() ? absl::OkStatus() : gap_;
}

absl::StatusOr<WatchStream::Message> WatchStream::Next(bool draining) {
  if (!opened_) {
    if (absl::Status status = Open(); !status.ok()) return status;
    opened_ = true;
    return MakeCreated();
  }
  while (true) {
    absl::StatusOr<Message> message = NextOfStep();
    if (!message.ok() || message->has_value()) return message;
    // A map in quarantine or deleted says so.
    if (absl::Status status = map_->condition(); !status.ok() && !draining) return status;
    const std::shared_ptr<const MapSnapshot> snapshot = map_->snapshot();
    if (next_snapshot_ == nullptr && gap_.ok() && snapshot->revision == position_.revision) break;
    message = TakeStep(snapshot);
    if (!message.ok() || message->has_value()) return message;
  }
  if (!draining) return Message();
  if (std::exchange(said_goodbye_, true)) return DrainingError();
  return MakeGoodbye();
}

/// The next message of the step under way; none, and no step, once it is whole.
absl::StatusOr<WatchStream::Message> WatchStream::NextOfStep() {
  while (step_ != nullptr) {
    if (place_ == step_->count()) {
      position_ = step_->after();
      shown_ = step_->shown();
      following_ = true;
      step_ = nullptr;
      break;
    }
    absl::StatusOr<Message> message = step_->At(place_++);
    if (!message.ok() || message->has_value()) return message;
  }
  return Message();
}

/// Takes the step that leads to `snapshot`; or a message to be sent first.
absl::StatusOr<WatchStream::Message> WatchStream::TakeStep(
    const std::shared_ptr<const MapSnapshot>& snapshot) {
  if (!gap_.ok()) return HandleGap(std::exchange(gap_, absl::OkStatus()), snapshot);
  WatchHub::StepRequest wanted{scope_,
                               filter_,
                               max_message_bytes_,
                               request_.takes_patches(),
                               false,
                               position_,
                               shown_,
                               snapshot,
                               [this] { return cancelled_.load(); }};
  if (next_snapshot_ != nullptr) {
    wanted.as_snapshot = true;
    wanted.before = {};
    wanted.shown = nullptr;
    wanted.snapshot = next_snapshot_;
  }
  absl::StatusOr<std::shared_ptr<WatchMessages>> step = surroundings_.hub->FindStep(wanted);
  if (absl::IsOutOfRange(step.status())) return HandleGap(step.status(), snapshot);
  if (!step.ok()) return step.status();
  step_ = *std::move(step);
  place_ = 0;
  next_snapshot_ = nullptr;
  return Message();
}

/// The history between the watcher and the map is gone: begins anew where that was asked for.
absl::StatusOr<WatchStream::Message> WatchStream::HandleGap(
    const absl::Status& gap, const std::shared_ptr<const MapSnapshot>& snapshot) {
  if (request_.resync_if_compacted()) {
    next_snapshot_ = snapshot;
    return MakeResync(snapshot->revision, ReasonOf(gap));
  }
  if (!following_) return gap;
  return MakeError(
      absl::StatusCode::kAborted,
      reason::kSlowConsumer,
      absl::StrCat("the watcher fell so far behind that the history it needs is gone: ",
                   std::string(gap.message())));
}

grpc::ByteBuffer WatchStream::MakeCreated() const {
  const MapConfig& config = map_->record().config;
  v1::WatchMapResponse message;
  v1::WatchCreated* created = message.mutable_created();
  created->set_revision(position_.revision.value());
  created->set_voxel_size_m(config.voxel_size_m);
  created->set_truncation_m(config.truncation_m);
  created->set_incarnation(scope_.incarnation);
  return Serialize(message);
}

}  // namespace steadymap

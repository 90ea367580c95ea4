#include "client/watch/map_watch.h"

#include <algorithm>
#include <random>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/time/time.h>

#include "client/transport/server_answer.h"
#include "client/watch/watch_retry.h"
#include "core/types/error.h"
#include "proto/convert_watch.h"
#include "proto/grpc_status.h"

namespace steadymap {
namespace {

using Clock = std::chrono::steady_clock;

WatchOptions WithSeed(WatchOptions options) {
  while (options.seed == 0) {
    std::random_device device;
    options.seed = (std::uint64_t{device()} << 32) | device();
  }
  return options;
}

// Returns the reason of a resync, reported to the consumer.
absl::Status ResyncReason(const v1::WatchResync& resync) {
  return MakeError(absl::StatusCode::kOutOfRange,
                   resync.reason(),
                   "the server no longer has the changes since the watcher's last revision");
}

v1::WatchStart StartOf(WatchOpening opening) {
  switch (opening) {
    case WatchOpening::kNow:
      return v1::WATCH_START_NOW;
    case WatchOpening::kSnapshot:
      return v1::WATCH_START_SNAPSHOT_THEN_FOLLOW;
    case WatchOpening::kResume:
      break;
  }
  return v1::WATCH_START_UNSPECIFIED;
}

}  // namespace

MapWatch::MapWatch(ChannelOpener open_channel,
                   const MapName& map,
                   WatchOptions options,
                   WatchConsumer* consumer)
    : map_(map.ToString()),
      options_(WithSeed(std::move(options))),
      open_channel_(std::move(open_channel)),
      consumer_(consumer),
      sequence_(options_.resync_if_compacted),
      thread_([this] { Run(); }) {}

MapWatch::~MapWatch() {
  {
    const absl::MutexLock lock(&mutex_);
    stopped_ = true;
    if (context_ != nullptr) context_->TryCancel();
  }
  thread_.join();
}

void MapWatch::Run() {
  Backoff backoff(options_.backoff, options_.seed);
  absl::Status status = CheckOptions();
  std::optional<WatchOpening> opening;
  if (status.ok()) opening = options_.start;
  while (opening) {
    const StreamEnd end = RunStream(*opening);
    if (IsStopped()) {
      consumer_->Discard();
      return;
    }
    status = end.violation.ok() ? end.status : end.violation;
    if (status.ok()) status = absl::UnavailableError("the server ended the watch");
    opening = NextOpening(end, *opening);
    // A step that the server repeatedly fails to complete must not be requested forever.
    if (end.was_created && !end.has_progressed && IsServerAnswer(end.status))
      sequence_.ForgetPart();
    // The received part of a step is kept for a stream that may resume within it.
    if (opening != WatchOpening::kResume || !sequence_.is_within_step()) consumer_->Discard();
    if (!opening) break;
    if (end.was_created && end.violation.ok()) backoff.NoteReached();
    // A watch whose streams repeatedly violate the protocol must not request snapshots at a high
    // rate.
    if (end.has_progressed && end.violation.ok()) backoff.Reset();
    if (!WaitBeforeRetry(status, DescribeFailure(end), &backoff)) break;
  }
  consumer_->Discard();
  if (!IsStopped()) consumer_->OnState({WatchState::kEnded, status});
}

absl::Status MapWatch::CheckOptions() const {
  const MapFilter& filter = options_.filter;
  if (!filter.events && !filter.states && !filter.volumes) {
    return absl::InvalidArgumentError("a watch must select events, objects or volumes");
  }
  for (const Box& box : filter.boxes_world) {
    if (box.isEmpty()) return absl::InvalidArgumentError("a watched box must not be empty");
  }
  if ((options_.start == WatchOpening::kResume) == options_.resume_token.empty()) {
    return absl::InvalidArgumentError("a resume token is required to resume, and only then");
  }
  if (options_.takes_patches && options_.start == WatchOpening::kNow) {
    return absl::InvalidArgumentError("leaf patches require a start with a snapshot or a token");
  }
  return absl::OkStatus();
}

MapWatch::StreamEnd MapWatch::RunStream(WatchOpening opening) {
  StreamEnd end;
  grpc::ClientContext context;
  if (!BeginStream(&context)) return end;
  const v1::WatchMapRequest request = RequestFor(opening);
  if (opening == WatchOpening::kNow && sequence_.revision() && resync_reason_.ok()) {
    resync_reason_ = absl::UnavailableError(
        absl::StrCat("the watch was interrupted before its first step; changes since revision ",
                     sequence_.revision()->value(),
                     " may be missing"));
  }
  sequence_.BeginStream(opening);
  const Clock::time_point start = Clock::now();
  const auto stub = v1::WatchService::NewStub(open_channel_());
  const std::unique_ptr<grpc::ClientReaderInterface<v1::WatchMapResponse>> stream =
      stub->WatchMap(&context, request);
  v1::WatchMapResponse message;
  while (stream->Read(&message)) {
    // Messages still in flight after the violation.
    if (!end.violation.ok()) continue;
    end.violation = Take(message);
    if (!end.violation.ok()) context.TryCancel();
    end.was_created = true;
    if (message.has_created()) continue;
    end.has_progressed = end.has_progressed || sequence_.is_within_step() ||
                         (message.has_progress() && sequence_.step().IsNews());
  }
  end.status = FromGrpcStatus(stream->Finish());
  EndStream();
  end.took = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start);
  return end;
}

v1::WatchMapRequest MapWatch::RequestFor(WatchOpening opening) const {
  v1::WatchMapRequest request;
  request.set_map(map_);
  request.set_start(StartOf(opening));
  if (opening == WatchOpening::kResume) {
    const std::string& newest = sequence_.resume_token();
    request.set_resume_token(newest.empty() ? options_.resume_token : newest);
  }
  *request.mutable_filter() = ToProto(options_.filter);
  request.set_takes_patches(options_.takes_patches);
  request.set_max_message_bytes(options_.max_message_bytes);
  request.set_resync_if_compacted(options_.resync_if_compacted);
  return request;
}

absl::Status MapWatch::Take(const v1::WatchMapResponse& message) {
  if (absl::Status status = sequence_.Take(message); !status.ok()) return status;
  switch (message.kind_case()) {
    case v1::WatchMapResponse::kCreated:
      return TakeCreated(message.created());
    case v1::WatchMapResponse::kSnapshot:
      return consumer_->TakeSnapshot(message.snapshot());
    case v1::WatchMapResponse::kDelta:
      return consumer_->TakeDelta(message.delta());
    case v1::WatchMapResponse::kEvents:
      return consumer_->TakeEvents(message.events());
    case v1::WatchMapResponse::kProgress:
      Commit();
      return absl::OkStatus();
    case v1::WatchMapResponse::kResync:
      resync_reason_ = ResyncReason(message.resync());
      consumer_->Discard();
      return consumer_->Resync(message.resync());
    default:
      // A goodbye needs no action before the stream ends.
      return absl::OkStatus();
  }
}

absl::Status MapWatch::TakeCreated(const v1::WatchCreated& created) {
  if (sequence_.continues_step()) {
    consumer_->OnState({WatchState::kConnected, absl::OkStatus()});
    return absl::OkStatus();
  }
  consumer_->Discard();
  const WatchOpening opening = sequence_.opening();
  if (absl::Status status = consumer_->Begin(created, opening); !status.ok()) return status;
  consumer_->OnState({WatchState::kConnected, absl::OkStatus()});
  if (opening != WatchOpening::kNow || resync_reason_.ok()) return absl::OkStatus();
  consumer_->OnState({WatchState::kResynced, std::exchange(resync_reason_, absl::OkStatus())});
  return absl::OkStatus();
}

void MapWatch::Commit() {
  consumer_->Commit(sequence_.step());
  if (!sequence_.step().is_snapshot || resync_reason_.ok()) return;
  consumer_->OnState({WatchState::kResynced, std::exchange(resync_reason_, absl::OkStatus())});
}

// Returns the start of the next stream; none if the watch ends.
std::optional<WatchOpening> MapWatch::NextOpening(const StreamEnd& end, WatchOpening last) {
  const bool has_token = !sequence_.resume_token().empty();
  NextWatch next = NextWatchAfter(end.status, options_.resync_if_compacted, has_token);
  if (!end.violation.ok()) {
    next = options_.resync_if_compacted ? NextWatch::kAfresh : NextWatch::kEnd;
  }
  switch (next) {
    case NextWatch::kEnd:
      return std::nullopt;
    case NextWatch::kResume:
      if (has_token) return WatchOpening::kResume;
      // No part of the snapshot that the token refers to is left.
      if (last == WatchOpening::kResume && options_.resume_token.empty()) {
        return WatchOpening::kSnapshot;
      }
      return last;
    case NextWatch::kAfresh:
      resync_reason_ = end.violation.ok() ? end.status : end.violation;
      return WatchOpening::kSnapshot;
  }
  return std::nullopt;
}

FailedTry MapWatch::DescribeFailure(const StreamEnd& end) const {
  FailedTry failed;
  failed.was_answered = end.status.ok() || !end.violation.ok() || IsServerAnswer(end.status);
  const std::chrono::milliseconds asked(RetryDelayMsOf(end.status));
  failed.asked = sequence_.reconnect_after().value_or(asked);
  // A watch of an unchanged map may last for hours, so its duration does not count. A replaced
  // `sleep` also replaces the clock.
  if (!end.was_created && !options_.sleep) failed.took = end.took;
  return failed;
}

// Returns true if the watch shall be tried again.
bool MapWatch::WaitBeforeRetry(const absl::Status& status,
                               const FailedTry& failed,
                               Backoff* backoff) {
  const std::optional<std::chrono::milliseconds> delay = backoff->NextDelay(failed);
  if (!delay) return false;
  consumer_->OnState({WatchState::kReconnecting, status, *delay});
  if (options_.sleep) options_.sleep(*delay);
  const absl::MutexLock lock(&mutex_);
  if (!options_.sleep) {
    mutex_.AwaitWithTimeout(absl::Condition(&stopped_), absl::FromChrono(*delay));
  }
  return !stopped_;
}

bool MapWatch::BeginStream(grpc::ClientContext* context) {
  const absl::MutexLock lock(&mutex_);
  if (stopped_) return false;
  context_ = context;
  return true;
}

void MapWatch::EndStream() {
  const absl::MutexLock lock(&mutex_);
  context_ = nullptr;
}

bool MapWatch::IsStopped() const {
  const absl::MutexLock lock(&mutex_);
  return stopped_;
}

}  // namespace steadymap

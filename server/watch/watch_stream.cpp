#include "server/watch/watch_stream.h"

#include <utility>

#include <absl/time/clock.h>
#include <grpcpp/server_context.h>
#include <spdlog/spdlog.h>

#include "core/types/error.h"
#include "proto/grpc_status.h"
#include "server/rpc/pool_call.h"
#include "server/rpc/request_reader.h"

namespace steadymap {

/// The reactor owned by gRPC; forwards the events to the stream.
class WatchStream::Reactor final : public GrpcReactor {
 public:
  explicit Reactor(std::shared_ptr<WatchStream> stream) : stream_(std::move(stream)) {}

  void OnWriteDone(bool ok) override { stream_->OnWritten(ok); }

  void OnCancel() override {
    stream_->cancellation_.Cancel();
    stream_->End(absl::CancelledError("the watcher has disconnected"));
  }

  void OnDone() override {
    stream_->OnGone();
    delete this;
  }

 private:
  const std::shared_ptr<WatchStream> stream_;
};

WatchStream::GrpcReactor* WatchStream::Start(const Dependencies& dependencies,
                                             grpc::CallbackServerContext* context,
                                             const grpc::ByteBuffer& request) {
  auto stream = std::make_shared<WatchStream>(dependencies, context);
  auto* reactor = new Reactor(stream);
  stream->reactor_ = reactor;
  v1::WatchMapRequest message;
  stream->request_status_ = steadymap::ReadRequest(request, kPlainRequestLimits, &message);
  if (stream->request_status_.ok()) {
    stream->session_.emplace(
        dependencies.maps, dependencies.hub, std::move(message), stream->cancellation_);
  }
  stream->Schedule();
  return reactor;
}

WatchStream::WatchStream(const Dependencies& dependencies, grpc::CallbackServerContext* context)
    : dependencies_(dependencies), peer_(context->peer()), context_(context) {}

void WatchStream::Wake() { Schedule(); }

void WatchStream::Drain() {
  {
    const absl::MutexLock lock(&mutex_);
    draining_ = true;
  }
  Schedule();
}

void WatchStream::End(const absl::Status& status) {
  bool is_first = false;
  {
    const absl::MutexLock lock(&mutex_);
    is_first = !end_;
    if (is_first) end_ = status;
  }
  if (is_first && ReasonOf(status) == reason::kSlowConsumer) {
    spdlog::info("map {}: {}", session_->map()->name().ToString(), std::string(status.message()));
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

std::shared_ptr<WatchMessages> WatchStream::step() const {
  const absl::MutexLock lock(&mutex_);
  return shared_step_;
}

absl::Time WatchStream::sending_since() const {
  const absl::MutexLock lock(&mutex_);
  return sending_since_;
}

void WatchStream::OnWritten(bool ok) {
  {
    const absl::MutexLock lock(&mutex_);
    sending_since_ = absl::InfiniteFuture();
    if (!ok && !end_) end_ = absl::CancelledError("the watcher has disconnected");
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
  const std::shared_ptr<MapRuntime>& map = session_->map();
  if (!absl::IsNotFound(status)) {
    for (auto& step : session_->StepsInPart()) dependencies_.hub->Hold(std::move(step));
  }
  dependencies_.hub->Leave(map->key(), shared_from_this());
  spdlog::debug("map {}: a watch ended at revision {}: {}",
                map->name().ToString(),
                session_->position().revision.value(),
                status.ToString());
}

/// Ensures that `Advance` checks the stream after this call.
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
  // A stream has at most one waiting task. A new task per message serves the streams in turn, so no
  // stream falls behind because others are served repeatedly.
  if (!dependencies_.pool->TrySubmit([self = shared_from_this()] { self->Advance(); })) {
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
      message = NextMessage(draining);
      return message.status();
    });
    const absl::MutexLock lock(&mutex_);
    if (session_) {
      revision_ = session_->position().revision;
      shared_step_ = session_->step();
    }
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

absl::StatusOr<WatchStream::Message> WatchStream::NextMessage(bool draining) {
  if (begun_) return session_->Next(draining);
  if (absl::Status status = ReadRequest(); !status.ok()) return status;
  const std::shared_ptr<MapRuntime>& map = session_->map();
  if (map->condition() == MapRuntime::Condition::kOpening) return Message();
  {
    const absl::MutexLock lock(&mutex_);
    entered_ = true;
  }
  // No commit is missed after this call.
  absl::Status status = dependencies_.hub->Enter(map->key(), shared_from_this());
  if (!status.ok()) return status;
  begun_ = true;
  return session_->Begin();
}

/// Reads the request at the first call, and schedules the stream for the opening of the map.
absl::Status WatchStream::ReadRequest() {
  if (std::exchange(has_read_request_, true)) return absl::OkStatus();
  absl::Status status = dependencies_.openings->Take(peer_, absl::Now());
  if (!status.ok()) return status;
  if (!session_) return request_status_;
  status = session_->ReadRequest();
  if (!status.ok()) return status;
  session_->map()->WhenOpened([self = shared_from_this()] { self->Schedule(); });
  return absl::OkStatus();
}

void WatchStream::Finish(const absl::Status& status) {
  {
    const absl::MutexLock lock(&mutex_);
    activity_ = Activity::kFinished;
  }
  reactor_->Finish(ToGrpcStatus(status));
}

}  // namespace steadymap

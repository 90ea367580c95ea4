#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "core/types/cancellation.h"
#include "core/types/error.h"
#include "proto/grpc_status.h"
#include "server/process/worker_pool.h"
#include "server/rpc/pool_call.h"
#include "server/rpc/request_reader.h"
#include "server/rpc/stream_limiter.h"

namespace steadymap {

/// The source of the messages of a server stream.
template <typename Message>
class MessageSource {
 public:
  virtual ~MessageSource() = default;

  /// Fills `message`, which is empty, with the next message. Returns false if there is none.
  virtual absl::StatusOr<bool> Next(Message* message) = 0;
};

/// A server-streaming call that sends the messages of a source, as bytes. Each message is made on a
/// thread pool after the previous one was written, so a slow client costs the memory of one message
/// and of the source. At any time either one task or one write is pending.
///
/// Ends with the status of the source; with `Cancelled` if the client has disconnected or its
/// deadline has passed; or with `Aborted`, reason `SLOW_CONSUMER`, if the limiter finds that the
/// client does not read. In the last case the status follows the pending message, for a client that
/// reads again. If the client reads nothing for another timeout, the call is cancelled.
/// Thread-safe.
template <typename Message>
class MessageStream final : public LimitedStream,
                            public std::enable_shared_from_this<MessageStream<Message>> {
 public:
  using Source = MessageSource<Message>;
  using GrpcReactor = grpc::ServerWriteReactor<grpc::ByteBuffer>;

  /// Makes the source, on the pool. The `Cancellation` is valid for the lifetime of the source.
  using Open = std::function<absl::StatusOr<std::unique_ptr<Source>>(const Cancellation&)>;

  /// The parts of the server that streams use. All of them must outlive the streams.
  struct Dependencies {
    WorkerPool* pool = nullptr;
    StreamLimiter* gate = nullptr;
  };

  /// Starts a stream. Calls `wait` immediately; `wait` must call its argument when the work may
  /// begin. The reactor deletes itself.
  static GrpcReactor* Start(const Dependencies& dependencies,
                            grpc::CallbackServerContext* context,
                            const std::function<void(std::function<void()>)>& wait,
                            Open open) {
    auto stream = std::make_shared<MessageStream>(dependencies, context, std::move(open));
    auto* reactor = new Reactor(stream);
    stream->reactor_ = reactor;
    if (absl::Status status = dependencies.gate->Enter(stream, context->peer()); !status.ok()) {
      stream->Finish(status);
      return reactor;
    }
    wait([stream] {
      if (!stream->dependencies_.pool->TrySubmit([stream] { stream->MakeNext(); })) {
        stream->Finish(PoolFullError());
      }
    });
    return reactor;
  }

  /// Used only by `Start`.
  MessageStream(const Dependencies& dependencies, grpc::CallbackServerContext* context, Open open)
      : dependencies_(dependencies), open_(std::move(open)), context_(context) {}

  void EndIfStalled(Clock::time_point now, Clock::duration timeout) override
      ABSL_LOCKS_EXCLUDED(mutex_) {
    {
      const absl::MutexLock lock(&mutex_);
      if (now - sending_since_ <= timeout) return;
      if (activity_ == Activity::kFinished) {
        if (context_ != nullptr) context_->TryCancel();
        return;
      }
      activity_ = Activity::kFinished;
      sending_since_ = now;
    }
    // No other thread uses the source now: the completion of the pending write only finds the state
    // kFinished.
    source_.reset();
    dependencies_.gate->Discount(this->shared_from_this());
    reactor_->Finish(
        ToGrpcStatus(MakeError(absl::StatusCode::kAborted,
                               reason::kSlowConsumer,
                               "the client has read nothing for longer than the stall timeout")));
  }

 private:
  /// The reactor owned by gRPC; forwards the events to the stream.
  class Reactor final : public GrpcReactor {
   public:
    explicit Reactor(std::shared_ptr<MessageStream> stream) : stream_(std::move(stream)) {}

    void OnWriteDone(bool ok) override { stream_->OnWritten(ok); }

    void OnCancel() override { stream_->cancellation_.Cancel(); }

    void OnDone() override {
      stream_->OnGone();
      delete this;
    }

   private:
    const std::shared_ptr<MessageStream> stream_;
  };

  enum class Activity { kWorking, kWriting, kFinished };

  static constexpr Clock::time_point kNotSending = Clock::time_point::max();

  void MakeNext() ABSL_LOCKS_EXCLUDED(mutex_) {
    bool more = false;
    const absl::Status status = RunGuarded([this, &more] {
      if (cancellation_.IsCancelled()) return ClientGone();
      if (source_ == nullptr) {
        absl::StatusOr<std::unique_ptr<Source>> source = open_(cancellation_);
        if (!source.ok()) return source.status();
        source_ = *std::move(source);
      }
      message_.Clear();
      const absl::StatusOr<bool> next = source_->Next(&message_);
      more = next.ok() && *next;
      return next.status();
    });
    if (!more) return Finish(status);
    Write();
  }

  void Write() ABSL_LOCKS_EXCLUDED(mutex_) {
    std::uint64_t number = 0;
    {
      const absl::MutexLock lock(&mutex_);
      activity_ = Activity::kWriting;
      number = ++writes_;
    }
    outgoing_ = ToByteBuffer(message_);
    reactor_->StartWrite(&outgoing_);
    // The stall timeout of this write starts now, unless the write is complete already.
    const absl::MutexLock lock(&mutex_);
    if (activity_ == Activity::kWriting && writes_ == number) sending_since_ = Clock::now();
  }

  void OnWritten(bool ok) ABSL_LOCKS_EXCLUDED(mutex_) {
    {
      const absl::MutexLock lock(&mutex_);
      if (activity_ == Activity::kFinished) return;
      activity_ = Activity::kWorking;
      sending_since_ = kNotSending;
    }
    if (!ok) return Finish(ClientGone());
    const auto self = this->shared_from_this();
    if (!dependencies_.pool->Submit([self] { self->MakeNext(); })) Finish(PoolFullError());
  }

  void OnGone() ABSL_LOCKS_EXCLUDED(mutex_) {
    {
      const absl::MutexLock lock(&mutex_);
      context_ = nullptr;
    }
    dependencies_.gate->Leave(this->shared_from_this());
  }

  void Finish(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_) {
    {
      const absl::MutexLock lock(&mutex_);
      activity_ = Activity::kFinished;
    }
    source_.reset();
    reactor_->Finish(ToGrpcStatus(status));
  }

  static absl::Status ClientGone() { return absl::CancelledError("the client has disconnected"); }

  const Dependencies dependencies_;
  const Open open_;
  Reactor* reactor_ = nullptr;  ///< Valid until it is finished.
  const Cancellation cancellation_;

  // Used only by the pending task or write.
  std::unique_ptr<Source> source_;
  Message message_;
  grpc::ByteBuffer outgoing_;  ///< Bytes of the pending write.

  mutable absl::Mutex mutex_;
  grpc::CallbackServerContext* context_ ABSL_GUARDED_BY(mutex_);  ///< Null after the call ended.
  Activity activity_ ABSL_GUARDED_BY(mutex_) = Activity::kWorking;
  std::uint64_t writes_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Number of writes started.
  /// Start of the pending write; for a stalled stream the time of its end.
  Clock::time_point sending_since_ ABSL_GUARDED_BY(mutex_) = kNotSending;
};

}  // namespace steadymap

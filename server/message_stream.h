#pragma once

#include <functional>
#include <memory>
#include <utility>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/support/server_callback.h>

#include "core/error.h"
#include "proto/grpc_status.h"
#include "server/pool_call.h"
#include "server/worker_pool.h"

namespace steadymap {

/// Makes the messages of a server stream, one at a time.
template <typename Message>
class MessageSource {
 public:
  virtual ~MessageSource() = default;

  /// Fills `message`, which is empty, with the next one; false if there are no more.
  virtual absl::StatusOr<bool> Next(Message* message) = 0;
};

/// Answers a call with the messages of a source: each is made on a pool, and only when the one
/// before it was written, so a client that reads slowly costs one message and the source. At any
/// moment either one task is under way or one write, so no lock is needed. Deletes itself.
template <typename Message>
class MessageStream final : public grpc::ServerWriteReactor<Message> {
 public:
  using Source = MessageSource<Message>;

  /// `wait` is called at once and calls what it is given when the work may begin; `open` then makes
  /// the source, on the pool too; `on_done` is called when the call is over.
  static MessageStream* Start(const std::function<void(std::function<void()>)>& wait,
                              WorkerPool* pool,
                              std::function<absl::StatusOr<std::unique_ptr<Source>>()> open,
                              std::function<void()> on_done) {
    auto* stream = new MessageStream(pool, std::move(open), std::move(on_done));
    wait([stream, pool] {
      if (!pool->TrySubmit([stream] { stream->MakeNext(); })) stream->End(PoolFullError());
    });
    return stream;
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return End(absl::CancelledError("the client has gone"));
    if (!pool_->Resume([this] { MakeNext(); })) End(PoolFullError());
  }

  void OnDone() override {
    on_done_();
    delete this;
  }

 private:
  MessageStream(WorkerPool* pool,
                std::function<absl::StatusOr<std::unique_ptr<Source>>()> open,
                std::function<void()> on_done)
      : pool_(pool), open_(std::move(open)), on_done_(std::move(on_done)) {}

  void MakeNext() {
    bool more = false;
    const absl::Status status = RunGuarded([this, &more] {
      if (source_ == nullptr) {
        absl::StatusOr<std::unique_ptr<Source>> source = open_();
        if (!source.ok()) return source.status();
        source_ = *std::move(source);
      }
      message_.Clear();
      const absl::StatusOr<bool> next = source_->Next(&message_);
      more = next.ok() && *next;
      return next.status();
    });
    if (more) {
      this->StartWrite(&message_);
    } else {
      End(status);
    }
  }

  void End(const absl::Status& status) { this->Finish(ToGrpcStatus(status)); }

  WorkerPool* const pool_;
  const std::function<absl::StatusOr<std::unique_ptr<Source>>()> open_;
  const std::function<void()> on_done_;
  std::unique_ptr<Source> source_;
  Message message_;
};

}  // namespace steadymap

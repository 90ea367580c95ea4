#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "server/mapping/map_directory.h"
#include "server/process/worker_pool.h"
#include "server/rpc/peer_limiter.h"
#include "server/watch/watch_hub.h"
#include "server/watch/watch_session.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// One `WatchMap` call: sends the messages of a `WatchSession`, each after the previous one was
/// written, and is idle while the map does not change. At any time at most one pool task or one
/// write is active; a wake-up in the meantime only sets a flag. The stream outlives the reactor
/// while a task or the hub refers to it. Thread-safe.
class WatchStream final : public ActiveWatch, public std::enable_shared_from_this<WatchStream> {
 public:
  using GrpcReactor = grpc::ServerWriteReactor<grpc::ByteBuffer>;

  /// The parts of the server that streams use. All of them must outlive the streams.
  struct Dependencies {
    MapDirectory* maps = nullptr;
    WatchHub* hub = nullptr;
    WorkerPool* pool = nullptr;
    PeerLimiter* openings = nullptr;
  };

  /// Starts a stream; `request` is a serialized `v1::WatchMapRequest`. The reactor deletes itself.
  static GrpcReactor* Start(const Dependencies& dependencies,
                            grpc::CallbackServerContext* context,
                            const grpc::ByteBuffer& request);

  /// Used only by `Start`.
  WatchStream(const Dependencies& dependencies, grpc::CallbackServerContext* context);

  void Wake() override;
  void Drain() override ABSL_LOCKS_EXCLUDED(mutex_);
  void End(const absl::Status& status) override ABSL_LOCKS_EXCLUDED(mutex_);
  void Cancel() override ABSL_LOCKS_EXCLUDED(mutex_);
  Revision revision() const override ABSL_LOCKS_EXCLUDED(mutex_);
  std::shared_ptr<WatchMessages> step() const override ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Time sending_since() const override ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  class Reactor;

  using Message = WatchSession::Message;

  enum class Activity { kIdle, kAdvancing, kWriting, kFinished };

  // Events from gRPC.
  void OnWritten(bool ok) ABSL_LOCKS_EXCLUDED(mutex_);
  void OnGone() ABSL_LOCKS_EXCLUDED(mutex_);

  void Schedule() ABSL_LOCKS_EXCLUDED(mutex_);
  void Submit() ABSL_LOCKS_EXCLUDED(mutex_);
  void Advance() ABSL_LOCKS_EXCLUDED(mutex_);
  void Finish(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

  absl::StatusOr<Message> NextMessage(bool draining) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status ReadRequest() ABSL_LOCKS_EXCLUDED(mutex_);

  const Dependencies dependencies_;
  const std::string peer_;
  absl::Status request_status_;      ///< Result of the parser; set at the start.
  Reactor* reactor_ = nullptr;       ///< Valid until it is finished.
  const Cancellation cancellation_;  ///< Cancelled if the watcher disconnects.

  // Used only by the thread that advances the stream.
  std::optional<WatchSession> session_;  ///< None for an invalid WatchMapRequest.
  bool has_read_request_ = false;
  bool begun_ = false;
  grpc::ByteBuffer outgoing_;  ///< Bytes of the pending write.

  mutable absl::Mutex mutex_;
  grpc::CallbackServerContext* context_ ABSL_GUARDED_BY(mutex_);  ///< Null after the call ended.
  Activity activity_ ABSL_GUARDED_BY(mutex_) = Activity::kIdle;
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;  ///< Woken since the last check of the map.
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  bool entered_ ABSL_GUARDED_BY(mutex_) = false;  ///< The hub contains the watch.
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
  Revision revision_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<WatchMessages> shared_step_ ABSL_GUARDED_BY(mutex_);  ///< Step of `session_`.
  absl::Time sending_since_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteFuture();
};

}  // namespace steadymap

#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "server/config/live_limits.h"
#include "server/config/server_config.h"
#include "server/mapping/map_directory.h"
#include "server/process/frame_budget.h"
#include "server/process/worker_pool.h"
#include "server/upload/batch_intake.h"
#include "server/upload/upload_opening.h"
#include "server/upload/upload_registry.h"
#include "server/upload/upload_responses.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// One `UploadFrames` call: reads batches within the client's credit and the memory budget, has
/// them processed, and reports their progress to the client.
///
/// Many threads change the state of a stream, but only one at a time drives it. A thread that
/// changes the state while no thread drives it performs the resulting gRPC operations, outside the
/// lock. Therefore at most one read, one write and one finish are pending, and none follows the
/// finish. The stream outlives the reactor while frames of it are in flight. Thread-safe.
class UploadStream final : public UploadObserver,
                           public ActiveUpload,
                           public std::enable_shared_from_this<UploadStream> {
 public:
  using GrpcReactor = grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>;

  /// The parts of the server that streams use. All of them must outlive the streams.
  struct Dependencies {
    MapDirectory* maps = nullptr;
    UploadRegistry* registry = nullptr;
    WorkerPool* decoders = nullptr;
    const LiveLimits* limits = nullptr;
    /// For messages of unary calls, which are read before their map is known.
    std::shared_ptr<FrameBudget::Account> call_account;
  };

  /// Starts the stream of a call. The reactor deletes itself.
  static GrpcReactor* Start(const Dependencies& dependencies, grpc::CallbackServerContext* context);

  /// Used only by `Start`.
  explicit UploadStream(const Dependencies& dependencies);

  bool IsAbandoned() const override ABSL_LOCKS_EXCLUDED(mutex_);
  void OnReceived(ClientSequence through, std::vector<RefusedFrame> refused) override;
  void OnDurable(const BatchProgress& progress) override;
  void OnIntegrated(const BatchProgress& progress) override;
  void OnFailed(const absl::Status& status) override;

  void End(const absl::Status& status) override;
  void Drain(const absl::Status& status) override;

 private:
  class Reactor;

  /// The next operation of the driving thread.
  enum class Action { kNone, kRead, kWrite, kStartIntake, kEndSession, kRequestCommit, kFinish };

  // Events from gRPC.
  void OnRead(bool ok) ABSL_LOCKS_EXCLUDED(mutex_);
  void OnWritten(bool ok) ABSL_LOCKS_EXCLUDED(mutex_);
  void OnCancelled() ABSL_LOCKS_EXCLUDED(mutex_);
  void OnGone() ABSL_LOCKS_EXCLUDED(mutex_);

  void Drive() ABSL_LOCKS_EXCLUDED(mutex_);
  Action Decide() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Perform(Action action) ABSL_LOCKS_EXCLUDED(mutex_);
  void StartIntake() ABSL_LOCKS_EXCLUDED(mutex_);
  void EndSession() ABSL_LOCKS_EXCLUDED(mutex_);
  void RequestCommit() ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsSessionOver() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsSettled() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  void AwaitMemory() ABSL_LOCKS_EXCLUDED(mutex_);
  void TakeMessage(FrameBudget::Reservation memory) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status HandleMessage(FrameBudget::Reservation memory) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status HandleOpen(const v1::UploadOpen& open) ABSL_LOCKS_EXCLUDED(mutex_);
  /// `known_durable`: the last frame acknowledged as durable, as reported by the client.
  void OnMapOpened(ClientSequence known_durable) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status HandleBatch(ReadBatch batch) ABSL_LOCKS_EXCLUDED(mutex_);

  const Dependencies dependencies_;
  const LimitOptions limits_;   ///< Limits at the start of the stream.
  Reactor* reactor_ = nullptr;  ///< Valid until it is finished.
  grpc::ByteBuffer request_;    ///< Pending read, or waiting for memory.
  grpc::ByteBuffer response_;   ///< Pending write.

  // Set once, by the reading thread and under the lock, before any batch is processed.
  std::shared_ptr<MapRuntime> map_;
  std::shared_ptr<const MapConfig> config_;  ///< Configuration of the map, shared by all batches.
  SessionName session_;

  MissingLabelsWarning missing_labels_;  ///< Used only by the reading thread.

  mutable absl::Mutex mutex_;
  bool driving_ ABSL_GUARDED_BY(mutex_) = false;
  bool reading_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  bool broken_ ABSL_GUARDED_BY(mutex_) = false;  ///< No message can be written any more.

  bool entered_ ABSL_GUARDED_BY(mutex_) = false;       ///< In the registry.
  bool awaiting_map_ ABSL_GUARDED_BY(mutex_) = false;  ///< The map is not open yet.
  std::optional<v1::UploadFramesResponse> opened_ ABSL_GUARDED_BY(mutex_);  ///< To be written.
  UploadResponses responses_ ABSL_GUARDED_BY(mutex_);
  std::deque<ReadBatch> inbox_ ABSL_GUARDED_BY(mutex_);  ///< At most one batch.
  bool intake_running_ ABSL_GUARDED_BY(mutex_) = false;  ///< A batch is being processed.
  /// Whether the end of the session was queued, and whether its decisions are in the map.
  bool end_queued_ ABSL_GUARDED_BY(mutex_) = false;
  bool end_integrated_ ABSL_GUARDED_BY(mutex_) = false;
  bool commit_requested_ ABSL_GUARDED_BY(mutex_) = false;

  ClientSequence last_read_ ABSL_GUARDED_BY(mutex_);       ///< Last frame of the newest batch.
  ClientSequence last_in_intake_ ABSL_GUARDED_BY(mutex_);  ///< Last frame of the batch in intake.
  ClientSequence last_accepted_ ABSL_GUARDED_BY(mutex_);   ///< Last frame in the queue or refused.
  BatchProgress durable_ ABSL_GUARDED_BY(mutex_);
  ClientSequence integrated_ ABSL_GUARDED_BY(mutex_);

  /// Status for the end after all accepted frames are integrated; empty: the stream continues.
  std::optional<absl::Status> drain_status_ ABSL_GUARDED_BY(mutex_);
  /// Status for the immediate end.
  std::optional<absl::Status> end_status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap

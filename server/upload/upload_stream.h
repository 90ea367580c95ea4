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

/// One `UploadFrames` call: reads batches as far as credit and memory allow, has them taken in, and
/// tells the client what becomes of them.
///
/// Many threads report to a stream, but one at a time drives it: whoever changes the state and
/// finds nobody driving takes what follows from it to gRPC, outside the lock. So there is one read,
/// one write and one finish at most, and none after the finish. The stream outlives the reactor as
/// long as frames of it are under way. Thread-safe.
class UploadStream final : public UploadObserver,
                           public ActiveUpload,
                           public std::enable_shared_from_this<UploadStream> {
 public:
  using GrpcReactor = grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>;

  /// What streams need of the server; all of it outlives them.
  struct Dependencies {
    MapDirectory* maps = nullptr;
    UploadRegistry* registry = nullptr;
    WorkerPool* decoders = nullptr;
    const LiveLimits* limits = nullptr;
    /// For messages of calls without a stream, which are read before it is known for which map.
    std::shared_ptr<FrameBudget::Account> call_account;
  };

  /// Starts a stream. The reactor deletes itself.
  static GrpcReactor* Start(const Dependencies& dependencies);

  /// Use `Start`.
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

  /// What is to be done next.
  enum class Action { kNone, kRead, kWrite, kTakeIn, kRequestCommit, kFinish };

  // Reports of gRPC.
  void OnRead(bool ok) ABSL_LOCKS_EXCLUDED(mutex_);
  void OnWritten(bool ok) ABSL_LOCKS_EXCLUDED(mutex_);
  void OnCancelled() ABSL_LOCKS_EXCLUDED(mutex_);
  void OnGone() ABSL_LOCKS_EXCLUDED(mutex_);

  void Drive() ABSL_LOCKS_EXCLUDED(mutex_);
  Action Decide() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Perform(Action action) ABSL_LOCKS_EXCLUDED(mutex_);
  void TakeIn() ABSL_LOCKS_EXCLUDED(mutex_);
  void RequestCommit() ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsSettled() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  void AwaitMemory() ABSL_LOCKS_EXCLUDED(mutex_);
  void TakeMessage(FrameBudget::Reservation memory) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status HandleMessage(FrameBudget::Reservation memory) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status HandleOpen(const v1::UploadOpen& open) ABSL_LOCKS_EXCLUDED(mutex_);
  /// `known_durable`: the last frame that the client knows to be durable.
  void OnMapOpened(ClientSequence known_durable) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status HandleBatch(ReadBatch batch) ABSL_LOCKS_EXCLUDED(mutex_);

  const Dependencies dependencies_;
  const LimitOptions limits_;   ///< As they were when the stream began.
  Reactor* reactor_ = nullptr;  ///< Valid until it has been finished.
  grpc::ByteBuffer request_;    ///< Of the read in flight, or waiting for memory.
  grpc::ByteBuffer response_;   ///< Of the write in flight.

  // Set once, by the reading side and under the lock, before any batch is taken in.
  std::shared_ptr<MapRuntime> map_;
  std::shared_ptr<const MapConfig> config_;  ///< Of the map; all batches share it.
  SessionName session_;

  MissingLabelsWarning missing_labels_;  ///< Of the reading side.

  mutable absl::Mutex mutex_;
  bool driving_ ABSL_GUARDED_BY(mutex_) = false;
  bool reading_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  bool broken_ ABSL_GUARDED_BY(mutex_) = false;  ///< Nothing can be written any more.

  bool entered_ ABSL_GUARDED_BY(mutex_) = false;                            ///< On the registry.
  bool awaiting_map_ ABSL_GUARDED_BY(mutex_) = false;                       ///< It is not open yet.
  std::optional<v1::UploadFramesResponse> opened_ ABSL_GUARDED_BY(mutex_);  ///< To be written.
  UploadResponses answers_ ABSL_GUARDED_BY(mutex_);
  std::deque<ReadBatch> inbox_ ABSL_GUARDED_BY(mutex_);  ///< At most one.
  bool taking_in_ ABSL_GUARDED_BY(mutex_) = false;       ///< A batch is being decoded.
  bool commit_requested_ ABSL_GUARDED_BY(mutex_) = false;

  ClientSequence last_read_ ABSL_GUARDED_BY(mutex_);       ///< Of the newest batch.
  ClientSequence last_in_intake_ ABSL_GUARDED_BY(mutex_);  ///< Of the newest batch in intake.
  ClientSequence last_taken_ ABSL_GUARDED_BY(mutex_);      ///< Of what is in the queue, or further.
  BatchProgress durable_ ABSL_GUARDED_BY(mutex_);
  ClientSequence integrated_ ABSL_GUARDED_BY(mutex_);

  /// How the stream ends, once everything that was taken is integrated; empty: it goes on.
  std::optional<absl::Status> ending_ ABSL_GUARDED_BY(mutex_);
  /// How it ends now.
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap

#pragma once

#include <memory>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/support/server_callback.h>

#include "server/upload/upload_stream.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// One `UploadFrameBatch` call: takes a batch in, and answers when it has come as far as asked.
/// Outlives the reactor as long as its frames are under way. Thread-safe.
class UploadCall final : public UploadObserver, public std::enable_shared_from_this<UploadCall> {
 public:
  /// Starts a call with a serialized `v1::UploadFrameBatchRequest`. The reactor deletes itself;
  /// `response` belongs to gRPC and lives as long as it does.
  static grpc::ServerUnaryReactor* Start(const UploadStream::Dependencies& dependencies,
                                         const grpc::ByteBuffer& request,
                                         grpc::ByteBuffer* response);

  /// Use `Start`.
  explicit UploadCall(const UploadStream::Dependencies& dependencies)
      : dependencies_(dependencies) {}

  bool IsAbandoned() const override ABSL_LOCKS_EXCLUDED(mutex_);
  void OnReceived(ClientSequence through, std::vector<RefusedFrame> refused) override;
  void OnDurable(const BatchProgress& progress) override;
  void OnIntegrated(const BatchProgress& progress) override;
  void OnFailed(const absl::Status& status) override;

 private:
  class Reactor;

  void AwaitMemory(const grpc::ByteBuffer& request);
  void TakeMessage(const grpc::ByteBuffer& request, FrameBudget::Reservation memory);
  absl::Status TakeIn(v1::UploadFrameBatchRequest request, FrameBudget::Reservation memory);
  void StartIntake(const SessionName& session);
  void AnswerIfDone() ABSL_LOCKS_EXCLUDED(mutex_);
  void Finish(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsDone() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  v1::UploadFrameBatchResponse MakeAnswer() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const UploadStream::Dependencies dependencies_;

  // Touched by none but whoever sets `finished_`.
  Reactor* reactor_ = nullptr;
  grpc::ByteBuffer* response_ = nullptr;

  // Set before anything is under way.
  std::shared_ptr<MapRuntime> map_;
  ReadBatch batch_;  ///< Until the map is open.
  v1::AckLevel level_ = v1::ACK_LEVEL_DURABLE;
  ClientSequence last_;  ///< Of the batch.

  mutable absl::Mutex mutex_;
  bool taken_in_ ABSL_GUARDED_BY(mutex_) = false;
  BatchProgress progress_ ABSL_GUARDED_BY(mutex_);  ///< The furthest of the pieces.
  ClientSequence durable_ ABSL_GUARDED_BY(mutex_);
  ClientSequence integrated_ ABSL_GUARDED_BY(mutex_);
  std::vector<RefusedFrame> refused_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace steadymap

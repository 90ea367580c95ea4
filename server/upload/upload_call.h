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

/// One `UploadFrameBatch` call: processes a batch and responds when it has reached the requested
/// acknowledgement level. Outlives the reactor while frames of it are in flight. Thread-safe.
class UploadCall final : public UploadObserver, public std::enable_shared_from_this<UploadCall> {
 public:
  /// Starts a call with a serialized `v1::UploadFrameBatchRequest`. The reactor deletes itself;
  /// `response` belongs to gRPC and is valid as long as the reactor.
  static grpc::ServerUnaryReactor* Start(const UploadStream::Dependencies& dependencies,
                                         const grpc::ByteBuffer& request,
                                         grpc::ByteBuffer* response);

  /// Used only by `Start`.
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
  absl::Status StartIntake(v1::UploadFrameBatchRequest request, FrameBudget::Reservation memory);
  void StartIntake(const SessionName& session);
  void AnswerIfDone() ABSL_LOCKS_EXCLUDED(mutex_);
  void Finish(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsDone() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  v1::UploadFrameBatchResponse MakeAnswer() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const UploadStream::Dependencies dependencies_;

  // Used only by the thread that sets `finished_`.
  Reactor* reactor_ = nullptr;
  grpc::ByteBuffer* response_ = nullptr;

  // Set before the intake starts.
  std::shared_ptr<MapRuntime> map_;
  ReadBatch batch_;  ///< Moved to the intake once the map is open.
  v1::AckLevel level_ = v1::ACK_LEVEL_DURABLE;
  ClientSequence last_;  ///< Last sequence of the batch.

  mutable absl::Mutex mutex_;
  bool intake_done_ ABSL_GUARDED_BY(mutex_) = false;
  BatchProgress progress_ ABSL_GUARDED_BY(mutex_);  ///< Maximum of all parts.
  ClientSequence durable_ ABSL_GUARDED_BY(mutex_);
  ClientSequence integrated_ ABSL_GUARDED_BY(mutex_);
  std::vector<RefusedFrame> refused_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace steadymap

#pragma once

#include <memory>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/support/server_callback.h>

#include "server/upload_stream.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// One `UploadFrameBatch` call: takes a batch in, and answers when it has come as far as asked.
/// Outlives the reactor as long as its frames are under way. Thread-safe.
class UploadCall final : public UploadObserver, public std::enable_shared_from_this<UploadCall> {
 public:
  /// Starts a call. The reactor deletes itself; `request` and `response` belong to gRPC and live as
  /// long as it does.
  static grpc::ServerUnaryReactor* Start(const UploadStream::Surroundings& surroundings,
                                         const v1::UploadFrameBatchRequest& request,
                                         v1::UploadFrameBatchResponse* response);

  bool IsAbandoned() const override ABSL_LOCKS_EXCLUDED(mutex_);
  void OnReceived(ClientSequence through, std::vector<RefusedFrame> refused) override;
  void OnDurable(const BatchProgress& progress) override;
  void OnIntegrated(const BatchProgress& progress) override;
  void OnFailed(const absl::Status& status) override;

 private:
  class Reactor;

  absl::Status TakeIn(const UploadStream::Surroundings& surroundings,
                      const v1::UploadFrameBatchRequest& request);
  void StartIntake(const UploadStream::Surroundings& surroundings,
                   const v1::UploadFrameBatchRequest& request,
                   const SessionName& session);
  void AnswerIfDone() ABSL_LOCKS_EXCLUDED(mutex_);
  void Finish(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsDone() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void FillAnswer() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  // Touched by none but whoever sets `finished_`.
  Reactor* reactor_ = nullptr;
  v1::UploadFrameBatchResponse* response_ = nullptr;

  std::shared_ptr<MapRuntime> map_;  ///< Set before anything is under way.
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

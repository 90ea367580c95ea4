#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/client_context.h>

#include "client/transport/channel.h"
#include "client/upload/upload_queue.h"
#include "client/upload/uploader.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/ingest_service.grpc.pb.h"
#include "steadymap/v1/map_service.grpc.pb.h"

namespace steadymap {

/// Implementation of FrameUploader: a queue, and a thread that keeps a stream open until every
/// frame is integrated. Each stream has a second thread that reads it.
class FrameUploader::Session {
 public:
  Session(ChannelOpener open_channel, const MapName& map, UploaderOptions options);
  ~Session();

  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  absl::Status Push(v1::Frame frame) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<UploadSummary> Finish() ABSL_LOCKS_EXCLUDED(mutex_);
  UploadProgress progress() const ABSL_LOCKS_EXCLUDED(mutex_);

  const std::string& name() const { return options_.session; }

 private:
  using Stream =
      grpc::ClientReaderWriterInterface<v1::UploadFramesRequest, v1::UploadFramesResponse>;

  /// State of the open stream, shared by the writing and the reading thread.
  struct StreamState {
    grpc::ClientContext* context = nullptr;  ///< Null without a stream.
    bool opened = false;                     ///< The server has answered the opening.
    bool ended = false;                      ///< Nothing more will be read.
    bool closed = false;                     ///< The server ended it with OK.
    absl::Status error;  ///< Client-side error; overrides the status of the stream.
  };

  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  FailedTry DescribeFailure(const absl::Status& status, std::chrono::milliseconds took) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  bool WaitBeforeRetry(const absl::Status& status, const FailedTry& failed, Backoff* backoff)
      ABSL_LOCKS_EXCLUDED(mutex_);

  absl::Status RunStream() ABSL_LOCKS_EXCLUDED(mutex_);
  bool BeginStream(grpc::ClientContext* context) ABSL_LOCKS_EXCLUDED(mutex_);
  bool AwaitOpened() ABSL_LOCKS_EXCLUDED(mutex_);
  void WriteBatches(Stream* stream) ABSL_LOCKS_EXCLUDED(mutex_);
  void ReadResponses(Stream* stream) ABSL_LOCKS_EXCLUDED(mutex_);
  bool ReadAgain(std::uint64_t client_seq) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Take(const v1::UploadFramesResponse& response, std::optional<LostFrames>* lost)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status ConfirmIntegration(const std::shared_ptr<grpc::ChannelInterface>& channel)
      ABSL_LOCKS_EXCLUDED(mutex_);
  std::uint64_t AskForRevision(const std::shared_ptr<grpc::ChannelInterface>& channel) const;

  v1::UploadFramesRequest OpenMessage() const ABSL_LOCKS_EXCLUDED(mutex_);
  void FailStream(const absl::Status& error) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  bool HasRoom() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool WriterHasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool OpeningIsOver() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string map_;
  const UploaderOptions options_;
  const ChannelOpener open_channel_;

  mutable absl::Mutex mutex_;
  UploadQueue queue_ ABSL_GUARDED_BY(mutex_);
  StreamState stream_ ABSL_GUARDED_BY(mutex_);
  bool finishing_ ABSL_GUARDED_BY(mutex_) = false;  ///< No more frames will be pushed.
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;  ///< The owner is being destroyed.
  bool done_ ABSL_GUARDED_BY(mutex_) = false;       ///< `result_` is final.
  absl::Status result_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t reconnections_ ABSL_GUARDED_BY(mutex_) = 0;

  std::thread thread_;  ///< Last member: it uses all members above.
};

}  // namespace steadymap

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/client_context.h>

#include "tests/contract/test_service.h"
#include "tests/support/wall_frame.h"

namespace steadymap {

/// Names an upload session of a map.
struct UploadSession {
  std::string map;
  std::string robot = "robot-1";
  std::string session = "session-1";
};

/// `count` wall frames, each seen from a little further along y than the one before.
v1::FrameBatch MakeBatch(std::uint64_t first_client_seq, int count);

/// One UploadFrames stream, driven step by step from the test's thread.
class UploadClient {
 public:
  explicit UploadClient(TestService* service);

  /// The stream's own end is left to the server if the test did not wait for it.
  ~UploadClient();

  /// Opens the session and reads the answer.
  absl::StatusOr<v1::UploadOpened> Open(const UploadSession& session,
                                        const std::vector<v1::AckLevel>& levels = {});

  /// Sends a message as it is; false if the stream is broken.
  bool Send(const v1::UploadFramesRequest& request);
  bool Send(const v1::FrameBatch& batch);

  /// Reads the next message; none at the end of the stream.
  std::optional<v1::UploadFramesResponse> Read();

  /// Reads on until all frames up to `client_seq` are at `level`; none if the stream ends before.
  std::optional<v1::UploadAck> ReadUntil(v1::AckLevel level, std::uint64_t client_seq);

  void HalfClose();
  void Cancel();

  /// Reads what there is and returns how the stream ended.
  absl::Status Finish();

  /// Half-closes and finishes.
  absl::Status Close();

  /// All frames refused so far.
  const std::vector<v1::RefusedFrame>& refused() const { return refused_; }

  /// The newest acknowledgement at `level`.
  const v1::UploadAck& newest(v1::AckLevel level) const {
    return acks_[static_cast<std::size_t>(level)];
  }

  /// Credit got since the start.
  const v1::UploadCredit& credit() const { return credit_; }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::UploadFramesRequest, v1::UploadFramesResponse>>
      stream_;
  std::vector<v1::RefusedFrame> refused_;
  std::vector<v1::UploadAck> acks_{4};
  v1::UploadCredit credit_;
  bool finished_ = false;
};

/// Uploads frames of one session and waits until they are integrated.
absl::Status UploadAndClose(TestService* service,
                            const UploadSession& session,
                            const v1::FrameBatch& batch);

/// Uploads one batch by a call.
absl::StatusOr<v1::UploadAck> UploadByCall(TestService* service,
                                           const UploadSession& session,
                                           const v1::FrameBatch& batch,
                                           v1::AckLevel wait_for);

}  // namespace steadymap

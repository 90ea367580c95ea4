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

/// Returns `count` wall frames with camera positions that advance along y.
v1::FrameBatch MakeBatch(std::uint64_t first_client_seq, int count);

/// One UploadFrames stream, driven step by step from the test's thread.
class UploadClient {
 public:
  explicit UploadClient(TestService* service);

  /// Does not wait for the end of the stream; the server ends it if the test has not.
  ~UploadClient();

  /// Opens the session and returns the response.
  absl::StatusOr<v1::UploadOpened> Open(const UploadSession& session,
                                        const std::vector<v1::AckLevel>& levels = {});

  /// Sends a message unchanged; false if the stream is broken.
  bool Send(const v1::UploadFramesRequest& request);
  bool Send(const v1::FrameBatch& batch);

  /// Reads the next message; none at the end of the stream.
  std::optional<v1::UploadFramesResponse> Read();

  /// Reads until all frames up to `client_seq` are at `level`; none if the stream ends before.
  std::optional<v1::UploadAck> ReadUntil(v1::AckLevel level, std::uint64_t client_seq);

  void HalfClose();
  void Cancel();

  /// Reads all remaining messages and returns the final status of the stream.
  absl::Status Finish();

  /// Half-closes and finishes.
  absl::Status Close();

  /// All frames refused so far.
  const std::vector<v1::RefusedFrame>& refused() const { return refused_; }

  /// The newest acknowledgement at `level`.
  const v1::UploadAck& newest(v1::AckLevel level) const {
    return acks_[static_cast<std::size_t>(level)];
  }

  /// Total credit received since the start.
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

/// Uploads one batch with a unary call.
absl::StatusOr<v1::UploadAck> UploadByCall(TestService* service,
                                           const UploadSession& session,
                                           const v1::FrameBatch& batch,
                                           v1::AckLevel wait_for);

}  // namespace steadymap

#pragma once

#include <memory>
#include <utility>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "server/rpc/pool_call.h"
#include "server/rpc/request_reader.h"

namespace steadymap {

/// The messages of a unary call that gRPC hands over as bytes, so that the request is bounded
/// before it is parsed. Copies share the messages; one thread at a time.
template <typename RequestMessage, typename ResponseMessage>
class MessageCall {
 public:
  /// Reads the request. `answer` belongs to gRPC and lives until the call is finished. Errors: as
  /// `ReadRequest`.
  static absl::StatusOr<MessageCall> Read(const grpc::ByteBuffer& bytes,
                                          const RequestLimits& limits,
                                          grpc::ByteBuffer* answer) {
    MessageCall call(answer);
    if (absl::Status status = ReadRequest(bytes, limits, &call.messages_->request); !status.ok()) {
      return status;
    }
    return call;
  }

  const RequestMessage& request() const { return messages_->request; }

  ResponseMessage* response() const { return &messages_->response; }

  /// Hands the response to gRPC if `status`, with which the call is to be finished, is OK. Returns
  /// `status`.
  absl::Status Answer(absl::Status status) const {
    if (status.ok()) *answer_ = ToByteBuffer(messages_->response);
    return status;
  }

 private:
  struct Messages {
    RequestMessage request;
    ResponseMessage response;
  };

  explicit MessageCall(grpc::ByteBuffer* answer)
      : answer_(answer), messages_(std::make_shared<Messages>()) {}

  grpc::ByteBuffer* answer_;
  std::shared_ptr<Messages> messages_;
};

/// Reads a call's request, and returns the reactor that `start` makes of the call; a call that
/// cannot be read ends at once with the reason.
template <typename Request, typename Response, typename Start>
grpc::ServerUnaryReactor* StartMessageCall(const grpc::ByteBuffer& bytes,
                                           grpc::ByteBuffer* answer,
                                           const RequestLimits& limits,
                                           const Start& start) {
  const auto call = MessageCall<Request, Response>::Read(bytes, limits, answer);
  return call.ok() ? start(*call) : RefuseCall(call.status());
}

}  // namespace steadymap

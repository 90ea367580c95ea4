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

/// Request and response of a unary call that gRPC passes as bytes, so that the size of the request
/// is checked before it is parsed. Copies share the messages. Not thread-safe.
template <typename RequestMessage, typename ResponseMessage>
class MessageCall {
 public:
  /// Parses the request. `answer` belongs to gRPC and is valid until the call is finished. Errors:
  /// those of `ReadRequest`.
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

  /// Passes the response to gRPC if `status` is OK. Returns `status`, with which the caller
  /// finishes the call.
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

/// Parses the request of a call and returns the reactor that `start` makes for it. A call with an
/// invalid request ends immediately with the error.
template <typename Request, typename Response, typename Start>
grpc::ServerUnaryReactor* StartMessageCall(const grpc::ByteBuffer& bytes,
                                           grpc::ByteBuffer* answer,
                                           const RequestLimits& limits,
                                           const Start& start) {
  const auto call = MessageCall<Request, Response>::Read(bytes, limits, answer);
  return call.ok() ? start(*call) : RefuseCall(call.status());
}

}  // namespace steadymap

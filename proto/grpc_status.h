#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/status.h>

namespace steadymap {

/// The gRPC status of a status, with the details of `proto/convert_status.h` in its trailer. Any
/// thread.
grpc::Status ToGrpcStatus(const absl::Status& status);

/// The status of a finished gRPC call: code, message and, if the server sent them, reason, field
/// path and retry delay (`ReasonOf`, `FieldOf`, `RetryDelayMsOf`). The status of gRPC for a message
/// above its size limit gets the reason `MESSAGE_TOO_LARGE`. Any thread.
absl::Status FromGrpcStatus(const grpc::Status& status);

}  // namespace steadymap

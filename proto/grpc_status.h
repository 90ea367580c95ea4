#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/status.h>

namespace steadymap {

/// A status for gRPC, with the details of `proto/convert_status.h` in its trailer. Any thread.
grpc::Status ToGrpcStatus(const absl::Status& status);

/// What a gRPC call ended with: code, message, and where the server gave them the reason and the
/// field path (`ReasonOf`, `FieldOf`). A message that gRPC itself finds too large has the reason
/// `MESSAGE_TOO_LARGE`. Any thread.
absl::Status FromGrpcStatus(const grpc::Status& status);

}  // namespace steadymap

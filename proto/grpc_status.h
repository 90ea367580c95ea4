#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/status.h>

#include "google/rpc/status.pb.h"

/// Statuses between core and the wire. Reason and field path of core/error.h travel as ErrorInfo
/// (domain `steadymap`) and BadRequest; both directions keep code, message, reason and field.
namespace steadymap {

google::rpc::Status ToRpcStatus(const absl::Status& status);

/// Details of other kinds or domains, and ones that do not parse, are ignored.
absl::Status FromRpcStatus(const google::rpc::Status& status);

/// The details travel in the `grpc-status-details-bin` trailer.
grpc::Status ToGrpcStatus(const absl::Status& status);

/// Statuses that gRPC itself made have no reason.
absl::Status FromGrpcStatus(const grpc::Status& status);

}  // namespace steadymap

#include "proto/grpc_status.h"

#include "core/types/error.h"
#include "proto/convert_status.h"

namespace steadymap {
namespace {

// Text of the status with which gRPC itself refuses a message above its limit. It has no details,
// because the service does not see the message.
constexpr char kMessageTooLargeText[] = "larger than max";

bool IsMessageTooLarge(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED &&
         status.error_details().empty() &&
         status.error_message().find(kMessageTooLargeText) != std::string::npos;
}

}  // namespace

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const v1::Status details = ToProto(status);
  return {static_cast<grpc::StatusCode>(details.code()),
          details.message(),
          details.details().empty() ? std::string() : details.SerializeAsString()};
}

absl::Status FromGrpcStatus(const grpc::Status& status) {
  if (IsMessageTooLarge(status)) {
    return MakeError(
        absl::StatusCode::kResourceExhausted, reason::kMessageTooLarge, status.error_message());
  }
  v1::Status details;
  // Other servers and proxies may send other details: use them only if their code equals that of
  // the status.
  if (status.error_details().empty() || !details.ParseFromString(status.error_details()) ||
      details.code() != static_cast<int>(status.error_code())) {
    details.Clear();
    details.set_code(static_cast<int>(status.error_code()));
  }
  details.set_message(status.error_message());
  return FromProto(details);
}

}  // namespace steadymap

#include "proto/grpc_status.h"

#include <string>

#include "core/error.h"

#include "google/rpc/error_details.pb.h"

namespace steadymap {
namespace {

constexpr char kDomain[] = "steadymap";

std::string MessageOf(const absl::Status& status) { return std::string(status.message()); }

}  // namespace

google::rpc::Status ToRpcStatus(const absl::Status& status) {
  google::rpc::Status message;
  message.set_code(static_cast<int>(status.code()));
  message.set_message(MessageOf(status));
  const std::string reason = ReasonOf(status);
  if (!reason.empty()) {
    google::rpc::ErrorInfo info;
    info.set_reason(reason);
    info.set_domain(kDomain);
    message.add_details()->PackFrom(info);
  }
  const std::string field = FieldOf(status);
  if (!field.empty()) {
    google::rpc::BadRequest bad_request;
    auto& violation = *bad_request.add_field_violations();
    violation.set_field(field);
    violation.set_description(MessageOf(status));
    message.add_details()->PackFrom(bad_request);
  }
  return message;
}

absl::Status FromRpcStatus(const google::rpc::Status& status) {
  std::string reason;
  std::string field;
  for (const google::protobuf::Any& detail : status.details()) {
    google::rpc::ErrorInfo info;
    google::rpc::BadRequest bad_request;
    if (detail.Is<google::rpc::ErrorInfo>() && detail.UnpackTo(&info)) {
      if (info.domain() == kDomain) reason = info.reason();
    } else if (detail.Is<google::rpc::BadRequest>() && detail.UnpackTo(&bad_request)) {
      if (bad_request.field_violations_size() > 0) field = bad_request.field_violations(0).field();
    }
  }
  const auto code = static_cast<absl::StatusCode>(status.code());
  if (reason.empty()) return {code, status.message()};
  return MakeError(code, reason, status.message(), field);
}

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  return {static_cast<grpc::StatusCode>(status.code()),
          MessageOf(status),
          ToRpcStatus(status).SerializeAsString()};
}

absl::Status FromGrpcStatus(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  google::rpc::Status message;
  if (!message.ParseFromString(status.error_details())) message.Clear();
  // The trailers that gRPC itself reads are the authority on code and message.
  message.set_code(status.error_code());
  message.set_message(status.error_message());
  return FromRpcStatus(message);
}

}  // namespace steadymap

#include "client/transport/server_answer.h"

#include "core/types/error.h"

namespace steadymap {

bool IsServerAnswer(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
      // Every error of the service has a reason; errors made by gRPC have none.
      return !ReasonOf(status).empty();
    default:
      return true;
  }
}

}  // namespace steadymap

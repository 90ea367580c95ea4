#include "client/upload/upload_retry.h"

#include "core/types/error.h"

namespace steadymap {

bool IsWorthRetrying(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDeadlineExceeded:
      return true;
    case absl::StatusCode::kAborted:
      return ReasonOf(status) != reason::kUploadSuperseded;
    case absl::StatusCode::kResourceExhausted:
      return ReasonOf(status) != reason::kMessageTooLarge;
    case absl::StatusCode::kDataLoss:
      // A batch damaged in transit; a map damaged on disk has another reason.
      return ReasonOf(status) == reason::kChecksum;
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kCancelled:
      // gRPC reports a connection that breaks within a message with these codes; errors of the
      // service always have a reason.
      return ReasonOf(status).empty();
    default:
      return false;
  }
}

}  // namespace steadymap

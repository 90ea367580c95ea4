#include "client/watch/watch_retry.h"

#include "core/types/error.h"

namespace steadymap {

NextWatch NextWatchAfter(const absl::Status& status, bool may_resync, bool had_token) {
  const auto resume_if = [](bool condition) {
    return condition ? NextWatch::kResume : NextWatch::kEnd;
  };
  const auto afresh_if = [](bool condition) {
    return condition ? NextWatch::kAfresh : NextWatch::kEnd;
  };
  switch (status.code()) {
    case absl::StatusCode::kOk:
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kAborted:
      return NextWatch::kResume;
    case absl::StatusCode::kResourceExhausted:
      return resume_if(ReasonOf(status) != reason::kMessageTooLarge);
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kCancelled:
      // gRPC reports a connection that breaks within a message with these codes; errors of the
      // service always have a reason.
      return resume_if(ReasonOf(status).empty());
    case absl::StatusCode::kOutOfRange:
      return afresh_if(may_resync);
    case absl::StatusCode::kInvalidArgument:
      return afresh_if(may_resync && had_token && ReasonOf(status) == reason::kBadResumeToken);
    default:
      return NextWatch::kEnd;
  }
}

}  // namespace steadymap

#pragma once

#include <absl/status/status.h>

#include "steadymap/v1/status.pb.h"

namespace steadymap {

/// A status with the standard details: ErrorInfo with the reason and the domain `steadymap`,
/// BadRequest where a field is to blame, and RetryInfo where trying again later may help. A status
/// without a reason carries no details. The message is cut at 1000 bytes, and what is not printable
/// ASCII becomes a question mark. Details carry the standard type URLs of google.rpc. Pure, any
/// thread.
v1::Status ToProto(const absl::Status& status);

/// The same the other way: code, message, reason, field path and, of at most 10 min, the delay
/// until another try (`RetryDelayMsOf`). A code that is none becomes `Unknown`; details of other
/// domains are ignored.
absl::Status FromProto(const v1::Status& message);

}  // namespace steadymap

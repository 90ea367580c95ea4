#pragma once

#include <absl/status/status.h>

#include "steadymap/v1/status.pb.h"

namespace steadymap {

/// The message of a status with the standard details: ErrorInfo with the reason and the domain
/// `steadymap`, BadRequest for an invalid field, and RetryInfo if a later attempt may succeed. A
/// status without a reason has no details. The text is cut at 1000 bytes, and a question mark
/// replaces each byte that is not printable ASCII. Details have the standard type URLs of
/// google.rpc. Pure, any thread.
v1::Status ToProto(const absl::Status& status);

/// The status of a message: code, text, reason, field path, and the delay of the next attempt
/// (`RetryDelayMsOf`), at most 10 min. An invalid code becomes `Unknown`; details of other domains
/// are ignored.
absl::Status FromProto(const v1::Status& message);

}  // namespace steadymap

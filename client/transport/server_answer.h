#pragma once

#include <absl/status/status.h>

namespace steadymap {

/// Whether the service itself ended a call with `status`. Otherwise it came from gRPC or from a
/// deadline of the client: the server could not be reached, did not answer, or went away.
bool IsServerAnswer(const absl::Status& status);

}  // namespace steadymap

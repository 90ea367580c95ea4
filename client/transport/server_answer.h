#pragma once

#include <absl/status/status.h>

namespace steadymap {

/// True if the service itself ended a call with `status`. False if `status` comes from gRPC or a
/// client deadline: the server was unreachable, did not answer, or closed the connection.
bool IsServerAnswer(const absl::Status& status);

}  // namespace steadymap

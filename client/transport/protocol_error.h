#pragma once

#include <absl/status/status.h>

#include "core/types/error.h"

namespace steadymap {

/// Returns the error for a server that violates the protocol: `Internal` with reason `INTERNAL` and
/// the message `what`, which describes the violation.
inline absl::Status ProtocolError(const char* what) {
  return MakeError(absl::StatusCode::kInternal, reason::kInternal, what);
}

}  // namespace steadymap

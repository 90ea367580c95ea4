#pragma once

#include <absl/status/status.h>

#include "core/types/error.h"

namespace steadymap {

/// The error of a server that breaks the protocol: `Internal` with reason `INTERNAL`; `what` says
/// what it did.
inline absl::Status ProtocolError(const char* what) {
  return MakeError(absl::StatusCode::kInternal, reason::kInternal, what);
}

}  // namespace steadymap

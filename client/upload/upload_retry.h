#pragma once

#include <absl/status/status.h>

namespace steadymap {

/// True if a failed upload stream may succeed on a new stream. False for OK, for errors that the
/// caller must fix first, and for `UPLOAD_SUPERSEDED`: a retry would take the session back, and the
/// two uploaders would supersede each other endlessly.
bool IsWorthRetrying(const absl::Status& status);

}  // namespace steadymap

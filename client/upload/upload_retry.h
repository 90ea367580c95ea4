#pragma once

#include <absl/status/status.h>

namespace steadymap {

/// Whether a failed upload stream may succeed when it is opened anew (service.md section 2). False
/// for OK, for what the caller must fix first, and for `UPLOAD_SUPERSEDED`: going on would take the
/// session back from the one that superseded it, and so for ever.
bool IsWorthRetrying(const absl::Status& status);

}  // namespace steadymap

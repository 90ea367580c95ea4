#pragma once

#include <string_view>

#include <absl/status/status.h>

#include "core/types/error.h"

namespace steadymap {

/// Returns the error for a record that passes its checksum but has impossible content: `DataLoss`
/// with reason `CHECKSUM`. `what` describes the invalid content.
inline absl::Status CorruptRecord(std::string_view what) {
  return MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, what);
}

}  // namespace steadymap

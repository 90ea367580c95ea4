#pragma once

#include <string_view>

#include <absl/status/status.h>

#include "core/types/error.h"

namespace steadymap {

/// The error of a record whose envelope is whole and whose content nobody can have written:
/// `DataLoss` with reason `CHECKSUM`; `what` says what it holds.
inline absl::Status CorruptRecord(std::string_view what) {
  return MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, what);
}

}  // namespace steadymap

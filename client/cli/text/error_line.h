#pragma once

#include <string>

#include <absl/status/status.h>

namespace steadymap {

/// Returns an error as one line without a line feed: the message, and the reason and the field if
/// the service sent them.
std::string ErrorLine(const absl::Status& status, const std::string& server);

}  // namespace steadymap

#pragma once

#include <string>

#include <absl/status/status.h>

namespace steadymap {

/// An error as one line without its line feed: what happened, and where the service named them the
/// reason and the field.
std::string ErrorLine(const absl::Status& status, const std::string& server);

}  // namespace steadymap

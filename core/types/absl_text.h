#pragma once

#include <string_view>

#include <absl/strings/string_view.h>

namespace steadymap {

/// Converts a text for abseil's functions. Abseil built for C++14, as in Debian, defines its own
/// `string_view` type.
inline absl::string_view Absl(std::string_view text) { return {text.data(), text.size()}; }

}  // namespace steadymap

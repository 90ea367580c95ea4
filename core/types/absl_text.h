#pragma once

#include <string_view>

#include <absl/strings/string_view.h>

namespace steadymap {

/// The same text for abseil's functions: where abseil is built for C++14, as Debian's is, its
/// `string_view` is a type of its own.
inline absl::string_view Absl(std::string_view text) { return {text.data(), text.size()}; }

}  // namespace steadymap

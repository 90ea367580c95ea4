#pragma once

#include <cstddef>

/// File descriptors of this process: every connection and every open file of a map takes one.
namespace steadymap {

/// The most that may be open now.
std::size_t DescriptorLimit();

/// How many more may be opened now. Cost: a look at each that is open.
std::size_t CountFreeDescriptors();

/// Those that connections may not take where the process may have `limit`: a quarter, from 64 to
/// 4096.
std::size_t ReservedDescriptors(std::size_t limit);

/// What a map in use may take, for its database and its log. A new one begins with 7.
inline constexpr std::size_t kDescriptorsOfAMap = 72;

}  // namespace steadymap

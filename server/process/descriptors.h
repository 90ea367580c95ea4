#pragma once

#include <cstddef>

/// File descriptors of this process. Each connection and each open file of a map uses one.
namespace steadymap {

/// Returns the maximum number of open descriptors.
std::size_t DescriptorLimit();

/// Returns the number of descriptors that can still be opened. Cost: reads one directory entry per
/// open descriptor.
std::size_t CountFreeDescriptors();

/// Returns the number of descriptors reserved for the store, which connections must not use: a
/// quarter of `limit`, clamped to [64, 4096].
std::size_t ReservedDescriptors(std::size_t limit);

/// Maximum number of descriptors of one open map, for its database and its log. A new map uses 7.
inline constexpr std::size_t kDescriptorsPerMap = 72;

}  // namespace steadymap

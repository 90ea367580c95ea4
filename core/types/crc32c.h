#pragma once

#include <cstdint>
#include <string_view>

namespace steadymap {

/// The CRC-32C (Castagnoli) of `data` that follows bytes whose CRC-32C is `crc`; start with 0, the
/// CRC-32C of nothing. `ExtendCrc32c(ExtendCrc32c(0, a), b)` is the CRC-32C of `a` and `b` joined.
/// Cost: about 0.6 ms a megabyte. Any thread.
std::uint32_t ExtendCrc32c(std::uint32_t crc, std::string_view data);

}  // namespace steadymap

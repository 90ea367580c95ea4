#pragma once

#include <cstdint>
#include <string_view>

namespace steadymap {

/// True if at least one disk sector (512 bytes) of `file` from `begin` on reads as zeros. Partial
/// sectors at both ends count as sectors.
///
/// A power cut may leave the last write to a file with its full length but without some of its
/// sectors, which then read as zeros. A zero sector therefore distinguishes an interrupted write,
/// which was never acknowledged as durable, from damage to a durable write.
bool HasZeroSector(std::string_view file, std::uint64_t begin);

}  // namespace steadymap

#pragma once

#include <cstdint>
#include <string_view>

namespace steadymap {

/// Whether a disk sector (512 bytes) of `file` from `begin` on reads as zeros; the parts of sectors
/// at both ends count as sectors.
///
/// A power cut may leave the last write to a file with its length but without some of its sectors,
/// which then read as zeros. That tells an interrupted write, which nobody was told is durable,
/// from damage to one that was.
bool LacksASector(std::string_view file, std::uint64_t begin);

}  // namespace steadymap

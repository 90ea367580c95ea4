#pragma once

#include <cstdint>
#include <string_view>

#include "core/types/identifiers.h"

namespace steadymap {

/// Returns the 64-bit FNV-1a hash of `bytes`, continued from `hash`.
std::uint64_t ExtendHash(std::uint64_t hash, std::string_view bytes);

/// The hash of the empty string: the initial value for `ExtendHash`.
inline constexpr std::uint64_t kEmptyHash = 0xCBF29CE484222325ULL;

/// Returns the hash of a map's history after a commit: the hash before the commit, extended by the
/// revision and by the bytes that the commit writes. If two histories differ in one commit, their
/// hashes differ from that commit on.
std::uint64_t ExtendHistory(std::uint64_t before, Revision revision, std::string_view change);

}  // namespace steadymap

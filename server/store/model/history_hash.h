#pragma once

#include <cstdint>
#include <string_view>

#include "core/types/identifiers.h"

namespace steadymap {

/// 64-bit FNV-1a of `bytes`, going on from `hash`.
std::uint64_t ExtendHash(std::uint64_t hash, std::string_view bytes);

/// The hash of the empty text: where `ExtendHash` starts.
inline constexpr std::uint64_t kEmptyHash = 0xCBF29CE484222325ULL;

/// The hash of a map's history after a commit: that before it, extended by the revision and by what
/// the commit wrote. Two histories that differ in one commit differ in it from there on.
std::uint64_t ExtendHistory(std::uint64_t before, Revision revision, std::string_view change);

}  // namespace steadymap

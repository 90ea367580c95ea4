#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <vector>

namespace steadymap {

/// Whether `a` comes before `b` when runs of digits are compared as numbers: `2.png` < `10.png`.
bool NaturallyBefore(std::string_view a, std::string_view b);

/// The entry of `folder` called `name`, upper and lower case being the same; empty if there is
/// none. An exact match wins.
std::filesystem::path FindEntry(const std::filesystem::path& folder, std::string_view name);

/// The files in `folder` whose name ends in one of `endings`, upper and lower case being the same,
/// in natural order. Empty if the folder is empty, missing or unreadable.
std::vector<std::filesystem::path> ListFiles(const std::filesystem::path& folder,
                                             std::initializer_list<std::string_view> endings);

/// The folders in `folder` in natural order.
std::vector<std::filesystem::path> ListFolders(const std::filesystem::path& folder);

}  // namespace steadymap

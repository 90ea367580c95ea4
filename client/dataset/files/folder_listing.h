#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <vector>

namespace steadymap {

/// True if `a` sorts before `b` when runs of digits are compared as numbers: `2.png` < `10.png`.
bool NaturallyBefore(std::string_view a, std::string_view b);

/// Returns the entry of `folder` with the name `name`, ignoring case; empty if there is none. An
/// exact match takes precedence.
std::filesystem::path FindEntry(const std::filesystem::path& folder, std::string_view name);

/// Returns the files in `folder` with a name that ends in one of `endings`, ignoring case, in
/// natural order. Empty if the folder is empty, missing or unreadable.
std::vector<std::filesystem::path> ListFiles(const std::filesystem::path& folder,
                                             std::initializer_list<std::string_view> endings);

/// Returns the folders in `folder` in natural order.
std::vector<std::filesystem::path> ListFolders(const std::filesystem::path& folder);

}  // namespace steadymap

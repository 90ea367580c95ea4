#include "client/dataset/files/folder_listing.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <system_error>

#include <absl/strings/match.h>

namespace steadymap {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Returns the run of digits at `start` without leading zeros.
std::string_view Digits(std::string_view text, std::size_t start, std::size_t* end) {
  *end = start;
  while (*end < text.size() && IsDigit(text[*end])) ++*end;
  while (start + 1 < *end && text[start] == '0') ++start;
  return text.substr(start, *end - start);
}

template <typename Predicate>
std::vector<std::filesystem::path> ListEntries(const std::filesystem::path& folder,
                                               Predicate predicate) {
  std::vector<std::filesystem::path> entries;
  std::error_code error;
  std::filesystem::directory_iterator iterator(folder, error);
  while (!error && iterator != std::filesystem::directory_iterator()) {
    if (predicate(*iterator)) entries.push_back(iterator->path());
    iterator.increment(error);
  }
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
    return NaturallyBefore(a.filename().string(), b.filename().string());
  });
  return entries;
}

}  // namespace

bool NaturallyBefore(std::string_view a, std::string_view b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (IsDigit(a[i]) && IsDigit(b[j])) {
      const std::string_view first = Digits(a, i, &i);
      const std::string_view second = Digits(b, j, &j);
      if (first.size() != second.size()) return first.size() < second.size();
      if (first != second) return first < second;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  if (i < a.size() || j < b.size()) return i == a.size();
  return a < b;  // Equal except for leading zeros: any fixed order is valid.
}

std::filesystem::path FindEntry(const std::filesystem::path& folder, std::string_view name) {
  std::error_code error;
  if (std::filesystem::exists(folder / name, error)) return folder / name;
  const std::vector<std::filesystem::path> matches =
      ListEntries(folder, [name](const std::filesystem::directory_entry& entry) {
        return absl::EqualsIgnoreCase(entry.path().filename().string(),
                                      absl::string_view(name.data(), name.size()));
      });
  return matches.empty() ? std::filesystem::path() : matches.front();
}

std::vector<std::filesystem::path> ListFiles(const std::filesystem::path& folder,
                                             std::initializer_list<std::string_view> endings) {
  return ListEntries(folder, [endings](const std::filesystem::directory_entry& entry) {
    std::error_code error;
    const std::string name = entry.path().filename().string();
    return entry.is_regular_file(error) &&
           std::any_of(endings.begin(), endings.end(), [&name](std::string_view ending) {
             return absl::EndsWithIgnoreCase(name, absl::string_view(ending.data(), ending.size()));
           });
  });
}

std::vector<std::filesystem::path> ListFolders(const std::filesystem::path& folder) {
  return ListEntries(folder, [](const std::filesystem::directory_entry& entry) {
    std::error_code error;
    return entry.is_directory(error);
  });
}

}  // namespace steadymap

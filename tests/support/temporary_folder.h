#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace steadymap {

/// A folder of its own for one test, removed with all it holds at the end.
class TemporaryFolder {
 public:
  /// Throws `std::system_error` if there is no place for it: the test then fails.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// Writes a file below the folder, making the folders it needs; returns its path.
  std::filesystem::path Write(const std::string& name, std::string_view content) const;

 private:
  std::filesystem::path path_;
};

/// The bytes of a file; empty if there is none.
std::string ContentOf(const std::filesystem::path& file);

}  // namespace steadymap

#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace steadymap {

/// A folder of one test's own, removed with all that is in it when the test ends.
class TemporaryFolder {
 public:
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

#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace steadymap {

/// A temporary folder for one test, removed with its content by the destructor.
class TemporaryFolder {
 public:
  /// Throws `std::system_error` if it cannot be created: the test then fails.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// Writes a file below the folder, creating parent folders; returns its path.
  std::filesystem::path Write(const std::string& name, std::string_view content) const;

 private:
  std::filesystem::path path_;
};

/// Returns the bytes of a file; empty if it does not exist.
std::string ContentOf(const std::filesystem::path& file);

}  // namespace steadymap

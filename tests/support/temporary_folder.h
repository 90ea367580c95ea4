#pragma once

#include <filesystem>

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

 private:
  std::filesystem::path path_;
};

}  // namespace steadymap

#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// A small value in a file and in a copy beside it (`NAME` and `NAME.copy`), each with a checksum:
/// damage to one of them costs nothing. One thread at a time.
class MirroredFile {
 public:
  explicit MirroredFile(std::filesystem::path path) : path_(std::move(path)) {}

  /// The value. One that only one of the files still has is written to the other again, and the log
  /// says so. Errors: `NotFound` if neither file is there; `DataLoss` with reason `CHECKSUM` if
  /// none of those that are there is whole.
  absl::StatusOr<std::string> Read() const;

  /// As `Read`, but changes nothing: what is wrong with either file is added to `problems`.
  absl::StatusOr<std::string> Inspect(std::vector<std::string>* problems) const;

  /// Replaces the value; on disk when it returns. A crash leaves the old value or the new one.
  absl::Status Write(std::string_view value) const;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path CopyPath() const { return path_.string() + ".copy"; }

  std::filesystem::path path_;
};

}  // namespace steadymap

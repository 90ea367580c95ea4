#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// A small value, stored in a file and in a copy beside it (`NAME` and `NAME.copy`), each with a
/// checksum. Damage to one of the two files loses nothing. One thread at a time.
class MirroredFile {
 public:
  explicit MirroredFile(std::filesystem::path path) : path_(std::move(path)) {}

  /// Returns the value. If only one of the files has a valid value, the other file is restored from
  /// it and a warning is logged. Errors: `NotFound` if neither file exists; `DataLoss` with reason
  /// `CHECKSUM` if no existing file is valid.
  absl::StatusOr<std::string> Read() const;

  /// Reads as `Read` does, but changes nothing. Adds the error of each damaged or missing file to
  /// `problems`.
  absl::StatusOr<std::string> Inspect(std::vector<std::string>* problems) const;

  /// Replaces the value, synced before it returns. A crash leaves the old value or the new one.
  absl::Status Write(std::string_view value) const;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path CopyPath() const { return path_.string() + ".copy"; }

  std::filesystem::path path_;
};

}  // namespace steadymap

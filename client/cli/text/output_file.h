#pragma once

#include <filesystem>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// A file that appears under its name only once it is complete: it is written beside it under a
/// temporary name, renamed by `Commit`, and removed otherwise.
class OutputFile {
 public:
  /// Errors: the reason why nothing can be written at `path`, with the path.
  static absl::StatusOr<OutputFile> Create(const std::filesystem::path& path);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  /// Appends, without a buffer in between. Errors: as the disk gives them, with the path.
  absl::Status Write(std::string_view data);

  /// Puts what was written on the disk: before `Commit`, so that a crash of the machine leaves this
  /// file or the one before, whole. Takes as long as the disk does. Errors: as `Write`.
  absl::Status Sync();

  /// Makes the file appear, in place of one that was there. Errors: as `Write`.
  absl::Status Commit();

 private:
  OutputFile(std::filesystem::path path, std::filesystem::path temporary_path);

  std::filesystem::path path_;
  std::filesystem::path temporary_path_;  ///< Empty once there is nothing left to remove.
  int descriptor_ = -1;                   ///< Below 0: not open.
};

/// OK if `path` ends as files of a format do, such as `.png`, in letters of either case.
/// Errors: `InvalidArgument` naming the path and the ending.
absl::Status CheckEnding(const std::filesystem::path& path, std::string_view ending);

/// Makes the folder and those around it where they do not exist.
/// Errors: `FailedPrecondition` with the folder and the reason.
absl::Status MakeFolder(const std::filesystem::path& folder);

}  // namespace steadymap

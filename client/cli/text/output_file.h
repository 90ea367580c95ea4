#pragma once

#include <filesystem>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// A file that appears under its name only when it is complete. It is written under a temporary
/// name in the same folder, renamed by `Commit`, and removed otherwise.
class OutputFile {
 public:
  /// Creates the temporary file. Errors: the reason why `path` cannot be written, with the path.
  static absl::StatusOr<OutputFile> Create(const std::filesystem::path& path);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  /// Appends `data` without buffering. Errors: the error of the file system, with the path.
  absl::Status Write(std::string_view data);

  /// Syncs the written data to disk. Called before `Commit`, it ensures that a crash of the machine
  /// leaves either this file or the previous one complete. Blocks until the disk has finished.
  /// Errors: as `Write`.
  absl::Status Sync();

  /// Renames the file to its name and replaces an existing file. Errors: as `Write`.
  absl::Status Commit();

 private:
  OutputFile(std::filesystem::path path, std::filesystem::path temporary_path);

  std::filesystem::path path_;
  std::filesystem::path temporary_path_;  ///< Empty when no file has to be removed.
  int descriptor_ = -1;                   ///< Negative: not open.
};

/// Checks that `path` has the extension `ending`, such as `.png`, ignoring case. Errors:
/// `InvalidArgument` with the path and the extension in the message.
absl::Status CheckEnding(const std::filesystem::path& path, std::string_view ending);

/// Creates the folder and its parents where they do not exist. Errors: `FailedPrecondition` with
/// the folder and the reason in the message.
absl::Status MakeFolder(const std::filesystem::path& folder);

}  // namespace steadymap

#pragma once

#include <filesystem>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// An exclusive lock on a data folder, held by one process through `flock` on the file `lock` in
/// it. The kernel releases it however the process ends.
class FolderLock {
 public:
  /// Creates the folder if it does not exist, and acquires the lock. Errors: `FailedPrecondition`
  /// if another process holds it; `PermissionDenied` or `NotFound` if the folder cannot be created
  /// or written.
  static absl::StatusOr<FolderLock> Take(const std::filesystem::path& folder);

  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;
};

/// Checks that the schema mark of `folder` contains this schema. Creates the mark, and the folder
/// `content`, if there is no mark. Must be called before any other file in the folder is read, so
/// that a store of a newer schema is left unchanged. `content` is the folder that every marked
/// store must contain. Errors: `FailedPrecondition` for another schema; `DataLoss` for an invalid
/// mark and for a marked folder without `content`; `PermissionDenied` or `NotFound` if the mark
/// cannot be written.
absl::Status CheckSchema(const std::filesystem::path& folder, const std::filesystem::path& content);

/// Schema of the data folder that this server writes. Incremented when an older server could not
/// read the folder. 1: one RocksDB for all maps, never released. 2: one folder for each map.
inline constexpr int kFolderSchema = 2;

}  // namespace steadymap

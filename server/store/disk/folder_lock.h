#pragma once

#include <filesystem>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// Holds a data folder for one process, by `flock` on the file `lock` in it; the kernel lets go of
/// it however the process ends.
class FolderLock {
 public:
  /// Makes the folder if need be and takes it.
  /// Errors: `FailedPrecondition` if somebody else holds it; `PermissionDenied` or `NotFound` if it
  /// cannot be made or written.
  static absl::StatusOr<FolderLock> Take(const std::filesystem::path& folder);

  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;
};

/// Checks that `folder` holds nothing or a store of this schema, and marks it as one of ours. Read
/// before anything else in the folder, so that a newer store is left exactly as it is. `content` is
/// the folder that a store cannot be without: made with the mark, and missed where the mark is.
/// Errors: `FailedPrecondition` for another schema; `DataLoss` for a mark that says something else,
/// and for a store without its content; `PermissionDenied` or `NotFound` if the mark cannot be
/// written.
absl::Status CheckSchema(const std::filesystem::path& folder, const std::filesystem::path& content);

/// Schema of the folder that this server writes. Rises when an older server could not read it.
/// 1: one RocksDB for all maps, never released. 2: a folder a map.
inline constexpr int kFolderSchema = 2;

}  // namespace steadymap

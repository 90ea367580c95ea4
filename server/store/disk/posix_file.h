#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <sys/types.h>
#include <sys/uio.h>

/// Access to those files of the data folder that RocksDB does not manage. All operations are direct
/// system calls, so that every failure is detected.
///
/// Errors of all functions: `NotFound` (no such file), `PermissionDenied`, `ResourceExhausted` with
/// reason `DISK_LOW` (no space, quota), otherwise `Internal`. The message contains the path.
namespace steadymap {

/// The system calls that a test can make fail.
enum class FileCall { kReserve, kWrite, kSync };

/// Called before each such system call, on any thread. Returns the errno with which the call must
/// fail, or 0.
using FileFaults = std::function<int(FileCall, const std::filesystem::path&)>;

/// Injects faults into the system calls of the process; empty: none. For tests.
void SetFileFaultsForTest(FileFaults faults);

/// An open file; closed when it is destroyed.
class PosixFile {
 public:
  /// Opens `path` with the `flags` of open(2). A file that it creates has mode 0640.
  static absl::StatusOr<PosixFile> Open(const std::filesystem::path& path, int flags);

  PosixFile() = default;
  ~PosixFile();
  PosixFile(PosixFile&& other) noexcept;
  PosixFile& operator=(PosixFile&& other) noexcept;

  int descriptor() const { return descriptor_; }

  const std::filesystem::path& path() const { return path_; }

  absl::StatusOr<std::uint64_t> Size() const;

  /// Reads `size` bytes from `offset`; fewer only at the end of the file.
  absl::StatusOr<std::string> ReadAt(std::uint64_t offset, std::size_t size) const;

  /// Writes the parts consecutively, starting at `offset`.
  absl::Status WriteAt(std::uint64_t offset, std::span<const std::string_view> parts) const;

  /// Reserves disk space for the next write, so that the write cannot run out of space halfway. The
  /// size of the file does not change. Returns OK on a file system that does not support
  /// reservation.
  absl::Status Reserve(std::uint64_t offset, std::uint64_t size) const;

  /// Truncates the file to `size` bytes.
  absl::Status Truncate(std::uint64_t size) const;

  /// Syncs the content and the size of the file to disk.
  absl::Status Sync() const;

 private:
  PosixFile(int descriptor, std::filesystem::path path);

  int descriptor_ = -1;
  std::filesystem::path path_;
};

/// Syncs the entries of `folder` (created, renamed and removed files) to disk.
absl::Status SyncFolder(const std::filesystem::path& folder);

/// Creates `folder` and its parents. An existing folder is not an error.
absl::Status MakeFolder(const std::filesystem::path& folder);

/// Renames a file or folder and syncs the change. Replaces an existing file.
absl::Status RenameDurably(const std::filesystem::path& from, const std::filesystem::path& to);

/// Replaces the content of `path` and syncs it. A crash leaves the old content or the new one.
absl::Status WriteFileDurably(const std::filesystem::path& path, std::string_view content);

/// Returns the whole content of `path`.
absl::StatusOr<std::string> ReadWholeFile(const std::filesystem::path& path);

/// Returns the error for a system call on `path` that failed with `error` (an errno); `doing`
/// completes "cannot ...".
absl::Status SystemError(int error, std::string_view doing, const std::filesystem::path& path);

}  // namespace steadymap

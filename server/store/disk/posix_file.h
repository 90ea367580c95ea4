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

/// Files of the data folder that are not RocksDB's: opened, read, written and synced through the
/// system's own calls, so that every failure is seen.
///
/// Errors of all: `NotFound` (no such file), `PermissionDenied`, `ResourceExhausted` with reason
/// `DISK_LOW` (no space, quota), else `Internal`; the message names the file.
namespace steadymap {

/// What a test can make fail.
enum class FileCall { kReserve, kWrite, kSync };

/// Asked before such calls, from any thread: an errno that the call is to fail with, or 0.
using FileFaults = std::function<int(FileCall, const std::filesystem::path&)>;

/// Puts faults into the calls of the process; empty: none any more. For tests.
void SetFileFaultsForTest(FileFaults faults);

/// An open file; closed when it is destroyed.
class PosixFile {
 public:
  /// Opens `path` with `flags` of open(2); files that it makes are readable by owner and group.
  static absl::StatusOr<PosixFile> Open(const std::filesystem::path& path, int flags);

  PosixFile() = default;
  ~PosixFile();
  PosixFile(PosixFile&& other) noexcept;
  PosixFile& operator=(PosixFile&& other) noexcept;

  int descriptor() const { return descriptor_; }

  const std::filesystem::path& path() const { return path_; }

  absl::StatusOr<std::uint64_t> Size() const;

  /// Reads up to `size` bytes from `offset` on; fewer only at the end of the file.
  absl::StatusOr<std::string> ReadAt(std::uint64_t offset, std::size_t size) const;

  /// Writes the parts one after another at `offset`.
  absl::Status WriteAt(std::uint64_t offset, std::span<const std::string_view> parts) const;

  /// Takes disk space for bytes that are about to be written, so that the write cannot run out of
  /// it halfway. The file's size stays. File systems that know no such thing: OK.
  absl::Status Reserve(std::uint64_t offset, std::uint64_t size) const;

  /// Cuts the file to `size` bytes.
  absl::Status Truncate(std::uint64_t size) const;

  /// Returns when content and size are on disk.
  absl::Status Sync() const;

 private:
  PosixFile(int descriptor, std::filesystem::path path);

  int descriptor_ = -1;
  std::filesystem::path path_;
};

/// Returns when the names in `folder` (files made, renamed, removed) are on disk.
absl::Status SyncFolder(const std::filesystem::path& folder);

/// Makes `folder` with its parents; a folder that is there is no error.
absl::Status MakeFolder(const std::filesystem::path& folder);

/// Renames a file or folder, replacing a file that is there; on disk when it returns.
absl::Status RenameDurably(const std::filesystem::path& from, const std::filesystem::path& to);

/// Replaces the content of `path` so that a crash leaves the old one or the new one; on disk when
/// it returns.
absl::Status WriteFileDurably(const std::filesystem::path& path, std::string_view content);

/// The whole content of `path`.
absl::StatusOr<std::string> ReadWholeFile(const std::filesystem::path& path);

/// The error for a system call on `path` that failed with `error` (an errno); `doing` completes
/// "cannot ...".
absl::Status SystemError(int error, std::string_view doing, const std::filesystem::path& path);

}  // namespace steadymap

#include "server/store/disk/posix_file.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/types/absl_text.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr mode_t kFileMode = 0640;

/// Converts the parts to the argument of writev(2), without the first `skipped` bytes.
std::vector<iovec> VectorOf(std::span<const std::string_view> parts, std::size_t skipped) {
  std::vector<iovec> vector;
  for (const std::string_view part : parts) {
    const std::size_t cut = std::min(skipped, part.size());
    skipped -= cut;
    if (cut == part.size()) continue;
    // writev(2) only reads the bytes, although its interface takes a non-const pointer.
    vector.push_back({const_cast<char*>(part.data()) + cut, part.size() - cut});
    if (vector.size() == IOV_MAX) break;
  }
  return vector;
}

/// Null except in tests.
std::atomic<std::shared_ptr<const FileFaults>> faults_for_test;

/// Returns the errno of the fault that a test injects into `call`; 0: none.
int FaultOf(FileCall call, const std::filesystem::path& path) {
  const std::shared_ptr<const FileFaults> faults = faults_for_test.load();
  return faults == nullptr ? 0 : (*faults)(call, path);
}

std::filesystem::path FolderOf(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

}  // namespace

void SetFileFaultsForTest(FileFaults faults) {
  faults_for_test = faults ? std::make_shared<const FileFaults>(std::move(faults)) : nullptr;
}

absl::Status SystemError(int error, std::string_view doing, const std::filesystem::path& path) {
  const std::error_code code(error, std::generic_category());
  const std::string message =
      absl::StrCat("cannot ", Absl(doing), " ", path.string(), ": ", code.message());
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return absl::NotFoundError(message);
    case EACCES:
    case EPERM:
    case EROFS:
      return absl::PermissionDeniedError(message);
    case ENOSPC:
    case EDQUOT:
      return MakeError(absl::StatusCode::kResourceExhausted, reason::kDiskLow, message);
    default:
      return MakeError(absl::StatusCode::kInternal, reason::kInternal, message);
  }
}

PosixFile::PosixFile(int descriptor, std::filesystem::path path)
    : descriptor_(descriptor), path_(std::move(path)) {}

PosixFile::~PosixFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

PosixFile::PosixFile(PosixFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

PosixFile& PosixFile::operator=(PosixFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  return *this;
}

absl::StatusOr<PosixFile> PosixFile::Open(const std::filesystem::path& path, int flags) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, kFileMode);
  if (descriptor < 0) return SystemError(errno, "open", path);
  return PosixFile(descriptor, path);
}

absl::StatusOr<std::uint64_t> PosixFile::Size() const {
  struct stat info {};

  if (::fstat(descriptor_, &info) != 0) return SystemError(errno, "read the size of", path_);
  return static_cast<std::uint64_t>(info.st_size);
}

absl::StatusOr<std::string> PosixFile::ReadAt(std::uint64_t offset, std::size_t size) const {
  std::string bytes(size, '\0');
  std::size_t done = 0;
  while (done < size) {
    const ssize_t got =
        ::pread(descriptor_, bytes.data() + done, size - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return SystemError(errno, "read", path_);
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

absl::Status PosixFile::WriteAt(std::uint64_t offset,
                                std::span<const std::string_view> parts) const {
  if (const int fault = FaultOf(FileCall::kWrite, path_)) {
    return SystemError(fault, "write", path_);
  }
  std::size_t done = 0;
  while (true) {
    const std::vector<iovec> vector = VectorOf(parts, done);
    if (vector.empty()) return absl::OkStatus();
    const ssize_t written = ::pwritev(descriptor_,
                                      vector.data(),
                                      static_cast<int>(vector.size()),
                                      static_cast<off_t>(offset + done));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return SystemError(errno, "write", path_);
    done += static_cast<std::size_t>(written);
  }
}

absl::Status PosixFile::Reserve(std::uint64_t offset, std::uint64_t size) const {
  if (size == 0) return absl::OkStatus();
  if (const int fault = FaultOf(FileCall::kReserve, path_)) {
    return SystemError(fault, "reserve disk space for", path_);
  }
  int result = 0;
  do {
    result = ::fallocate(
        descriptor_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(offset), static_cast<off_t>(size));
  } while (result != 0 && errno == EINTR);
  if (result == 0 || errno == EOPNOTSUPP || errno == ENOSYS) return absl::OkStatus();
  return SystemError(errno, "reserve disk space for", path_);
}

absl::Status PosixFile::Truncate(std::uint64_t size) const {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) == 0) return absl::OkStatus();
  return SystemError(errno, "truncate", path_);
}

absl::Status PosixFile::Sync() const {
  if (const int fault = FaultOf(FileCall::kSync, path_)) return SystemError(fault, "sync", path_);
  if (::fdatasync(descriptor_) == 0) return absl::OkStatus();
  return SystemError(errno, "sync", path_);
}

absl::Status SyncFolder(const std::filesystem::path& folder) {
  const absl::StatusOr<PosixFile> opened = PosixFile::Open(folder, O_RDONLY | O_DIRECTORY);
  if (!opened.ok()) return opened.status();
  if (::fsync(opened->descriptor()) == 0) return absl::OkStatus();
  return SystemError(errno, "sync", folder);
}

absl::Status MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  return error ? SystemError(error.value(), "make folder", folder) : absl::OkStatus();
}

absl::Status RenameDurably(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) return SystemError(errno, "rename", from);
  if (absl::Status status = SyncFolder(FolderOf(to)); !status.ok()) return status;
  return FolderOf(from) == FolderOf(to) ? absl::OkStatus() : SyncFolder(FolderOf(from));
}

absl::Status WriteFileDurably(const std::filesystem::path& path, std::string_view content) {
  const std::filesystem::path fresh = path.string() + ".new";
  {
    const absl::StatusOr<PosixFile> file = PosixFile::Open(fresh, O_WRONLY | O_CREAT | O_TRUNC);
    if (!file.ok()) return file.status();
    if (absl::Status status = file->WriteAt(0, {&content, 1}); !status.ok()) return status;
    if (absl::Status status = file->Sync(); !status.ok()) return status;
  }
  return RenameDurably(fresh, path);
}

absl::StatusOr<std::string> ReadWholeFile(const std::filesystem::path& path) {
  const absl::StatusOr<PosixFile> file = PosixFile::Open(path, O_RDONLY);
  if (!file.ok()) return file.status();
  const absl::StatusOr<std::uint64_t> size = file->Size();
  if (!size.ok()) return size.status();
  return file->ReadAt(0, *size);
}

}  // namespace steadymap

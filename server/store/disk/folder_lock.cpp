#include "server/store/disk/folder_lock.h"

#include <cerrno>
#include <charconv>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "core/types/absl_text.h"
#include "core/types/error.h"
#include "server/store/disk/mirrored_file.h"
#include "server/store/disk/posix_file.h"

namespace steadymap {
namespace {

constexpr char kLockFile[] = "lock";
constexpr char kSchemaFile[] = "schema";
constexpr std::string_view kSchemaPrefix = "steadymap store ";

absl::Status CannotUse(const std::filesystem::path& path, const std::error_code& error) {
  const bool forbidden = error == std::errc::permission_denied ||
                         error == std::errc::operation_not_permitted ||
                         error == std::errc::read_only_file_system;
  const absl::StatusCode code =
      forbidden ? absl::StatusCode::kPermissionDenied : absl::StatusCode::kNotFound;
  return {code, absl::StrCat("cannot write to data folder ", path.string(), ": ", error.message())};
}

std::error_code LastError() { return {errno, std::generic_category()}; }

std::string SchemaText() { return absl::StrCat(Absl(kSchemaPrefix), kFolderSchema, "\n"); }

/// Returns the schema number in a mark; 0 if the mark contains none.
int SchemaOf(std::string_view text) {
  int schema = 0;
  if (text.starts_with(kSchemaPrefix)) {
    text.remove_prefix(kSchemaPrefix.size());
    std::from_chars(text.data(), text.data() + text.size(), schema);
  }
  return schema;
}

}  // namespace

absl::StatusOr<FolderLock> FolderLock::Take(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return CannotUse(folder, error);
  const int descriptor = ::open((folder / kLockFile).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640);
  if (descriptor < 0) return CannotUse(folder, LastError());
  FolderLock lock(descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return CannotUse(folder, LastError());
    return absl::FailedPreconditionError(
        absl::StrCat("data folder ", folder.string(), " is held by another steadymapd"));
  }
  return lock;
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

absl::Status CheckSchema(const std::filesystem::path& folder,
                         const std::filesystem::path& content) {
  const MirroredFile mark(folder / kSchemaFile);
  absl::StatusOr<std::string> text = mark.Read();
  std::error_code error;
  const bool has_content = std::filesystem::is_directory(content, error);
  if (absl::IsNotFound(text.status())) {
    if (absl::Status status = MakeFolder(content); !status.ok()) return status;
    if (absl::Status status = SyncFolder(folder); !status.ok()) return status;
    return mark.Write(SchemaText());
  }
  // The first schema stored its mark in a single file without a checksum.
  if (!text.ok()) text = ReadWholeFile(mark.path());
  const int schema = text.ok() ? SchemaOf(*text) : 0;
  if (schema <= 0) {
    return MakeError(
        absl::StatusCode::kDataLoss,
        reason::kChecksum,
        absl::StrCat("file ", mark.path().string(), " does not contain the schema of a store"));
  }
  if (schema != kFolderSchema) {
    return absl::FailedPreconditionError(
        absl::StrCat("data folder ",
                     folder.string(),
                     schema > kFolderSchema ? " was written by a newer server: schema "
                                            : " was written before the first release: schema ",
                     schema,
                     ", but this server reads schema ",
                     kFolderSchema));
  }
  if (has_content) return absl::OkStatus();
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("data folder ",
                                folder.string(),
                                " holds a store, but its folder ",
                                content.filename().string(),
                                " is missing"));
}

}  // namespace steadymap

#include "server/folder_lock.h"

#include <cerrno>
#include <charconv>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "core/error.h"

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

// Written under another name first: a crash leaves no half a mark.
absl::Status WriteSchema(const std::filesystem::path& file) {
  const std::string text = absl::StrCat(
      absl::string_view(kSchemaPrefix.data(), kSchemaPrefix.size()), kFolderSchema, "\n");
  const std::filesystem::path fresh = file.string() + ".new";
  const int descriptor = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640);
  if (descriptor < 0) return CannotUse(file.parent_path(), LastError());
  const bool written =
      ::write(descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
      ::fsync(descriptor) == 0;
  const std::error_code error = LastError();
  ::close(descriptor);
  if (!written) return CannotUse(file.parent_path(), error);
  std::error_code rename_error;
  std::filesystem::rename(fresh, file, rename_error);
  return rename_error ? CannotUse(file.parent_path(), rename_error) : absl::OkStatus();
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

absl::Status CheckSchema(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kSchemaFile;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return WriteSchema(file);
  std::ifstream stream(file);
  const std::string text((std::istreambuf_iterator<char>(stream)),
                         std::istreambuf_iterator<char>());
  int schema = 0;
  if (text.starts_with(kSchemaPrefix)) {
    std::from_chars(text.data() + kSchemaPrefix.size(), text.data() + text.size(), schema);
  }
  if (schema <= 0) {
    return MakeError(absl::StatusCode::kDataLoss,
                     reason::kChecksum,
                     absl::StrCat("file ", file.string(), " does not name the store's schema"));
  }
  if (schema > kFolderSchema) {
    return absl::FailedPreconditionError(absl::StrCat("data folder ",
                                                      folder.string(),
                                                      " was written by a newer server: schema ",
                                                      schema,
                                                      ", this one knows ",
                                                      kFolderSchema));
  }
  return absl::OkStatus();
}

}  // namespace steadymap

#include "client/cli/text/output_file.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <unistd.h>

#include "core/types/absl_text.h"

namespace steadymap {
namespace {

constexpr int kFileMode = 0666;  // Reduced by the umask.

absl::Status CannotWrite(const std::filesystem::path& path, std::error_code error) {
  return absl::FailedPreconditionError(
      absl::StrCat("cannot write ", path.string(), ": ", error.message()));
}

std::error_code LastError() { return {errno, std::generic_category()}; }

}  // namespace

OutputFile::OutputFile(std::filesystem::path path, std::filesystem::path temporary_path)
    : path_(std::move(path)),
      temporary_path_(std::move(temporary_path)),
      descriptor_(
          open(temporary_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kFileMode)) {}

absl::StatusOr<OutputFile> OutputFile::Create(const std::filesystem::path& path) {
  std::error_code ignored;
  if (path.empty() || std::filesystem::is_directory(path, ignored)) {
    return CannotWrite(path, std::make_error_code(std::errc::is_a_directory));
  }
  std::filesystem::path temporary_path = path;
  temporary_path += absl::StrCat(".", getpid(), ".partial");
  OutputFile file(path, std::move(temporary_path));
  if (file.descriptor_ < 0) {
    const std::error_code error = LastError();
    file.temporary_path_.clear();
    return CannotWrite(path, error);
  }
  return file;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_path_(std::exchange(other.temporary_path_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) close(descriptor_);
  if (temporary_path_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove(temporary_path_, ignored);
}

absl::Status OutputFile::Write(std::string_view data) {
  while (!data.empty()) {
    const ssize_t written = write(descriptor_, data.data(), data.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return CannotWrite(path_, LastError());
    data.remove_prefix(static_cast<std::size_t>(written));
  }
  return absl::OkStatus();
}

absl::Status OutputFile::Sync() {
  return fsync(descriptor_) == 0 ? absl::OkStatus() : CannotWrite(path_, LastError());
}

absl::Status OutputFile::Commit() {
  if (close(std::exchange(descriptor_, -1)) != 0) return CannotWrite(path_, LastError());
  std::error_code error;
  std::filesystem::rename(temporary_path_, path_, error);
  if (error) return CannotWrite(path_, error);
  temporary_path_.clear();
  return absl::OkStatus();
}

absl::Status CheckEnding(const std::filesystem::path& path, std::string_view ending) {
  if (absl::AsciiStrToLower(path.extension().string()) == ending) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("expected a file name that ends in ", Absl(ending), ", got ", path.string()));
}

absl::Status MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("cannot make the folder ", folder.string(), ": ", error.message()));
}

}  // namespace steadymap

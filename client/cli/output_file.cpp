#include "client/cli/output_file.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <unistd.h>

namespace steadymap {
namespace {

absl::Status CannotWrite(const std::filesystem::path& path, std::error_code error) {
  return absl::FailedPreconditionError(
      absl::StrCat("cannot write ", path.string(), ": ", error.message()));
}

// A stream tells that it failed; the system's last error tells why.
std::error_code LastError() { return {errno, std::generic_category()}; }

}  // namespace

OutputFile::OutputFile(std::filesystem::path path, std::filesystem::path temporary_path)
    : path_(std::move(path)),
      temporary_path_(std::move(temporary_path)),
      stream_(temporary_path_, std::ios::binary | std::ios::trunc) {}

absl::StatusOr<OutputFile> OutputFile::Create(const std::filesystem::path& path) {
  std::error_code ignored;
  if (path.empty() || std::filesystem::is_directory(path, ignored)) {
    return CannotWrite(path, std::make_error_code(std::errc::is_a_directory));
  }
  std::filesystem::path temporary_path = path;
  temporary_path += absl::StrCat(".", getpid(), ".partial");
  OutputFile file(path, std::move(temporary_path));
  if (!file.stream_) {
    const std::error_code error = LastError();
    file.temporary_path_.clear();
    return CannotWrite(path, error);
  }
  return file;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_path_(std::exchange(other.temporary_path_, {})),
      stream_(std::move(other.stream_)) {}

OutputFile::~OutputFile() {
  if (temporary_path_.empty()) return;
  stream_.close();
  std::error_code ignored;
  std::filesystem::remove(temporary_path_, ignored);
}

absl::Status OutputFile::Write(std::string_view data) {
  stream_.write(data.data(), static_cast<std::streamsize>(data.size()));
  return stream_ ? absl::OkStatus() : CannotWrite(path_, LastError());
}

absl::Status OutputFile::Commit() {
  stream_.close();
  if (!stream_) return CannotWrite(path_, LastError());
  std::error_code error;
  std::filesystem::rename(temporary_path_, path_, error);
  if (error) return CannotWrite(path_, error);
  temporary_path_.clear();
  return absl::OkStatus();
}

}  // namespace steadymap

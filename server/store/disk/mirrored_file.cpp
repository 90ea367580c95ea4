#include "server/store/disk/mirrored_file.h"

#include <cstdint>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "core/types/crc32c.h"
#include "core/types/error.h"
#include "server/store/disk/posix_file.h"

namespace steadymap {
namespace {

// File format: a readable line, so that `cat` shows the purpose of the file. The line ends with the
// CRC-32C of the value in hexadecimal. The value follows the newline.
constexpr std::string_view kMark = "steadymap value, CRC-32C ";
constexpr std::size_t kChecksumDigits = 8;

std::string Pack(std::string_view value) {
  std::string packed(kMark);
  absl::StrAppend(&packed, absl::Hex(ExtendCrc32c(0, value), absl::kZeroPad8), "\n");
  packed.append(value);
  return packed;
}

absl::StatusOr<std::string> ReadOne(const std::filesystem::path& path) {
  absl::StatusOr<std::string> packed = ReadWholeFile(path);
  if (!packed.ok()) return packed;
  constexpr std::size_t kPrefixBytes = kMark.size() + kChecksumDigits + 1;
  if (packed->size() >= kPrefixBytes) {
    std::string value = packed->substr(kPrefixBytes);
    if (Pack(value) == *packed) return value;
  }
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("file ", path.string(), " does not match its checksum"));
}

void Repair(const std::filesystem::path& damaged, const std::string& value) {
  const absl::Status status = WriteFileDurably(damaged, Pack(value));
  if (status.ok()) {
    spdlog::warn("file {} was missing or damaged; restored from its copy", damaged.string());
  } else {
    spdlog::error("file {} is missing or damaged, and cannot be restored from its copy: {}",
                  damaged.string(),
                  std::string(status.message()));
  }
}

}  // namespace

absl::StatusOr<std::string> MirroredFile::Read() const {
  absl::StatusOr<std::string> first = ReadOne(path_);
  absl::StatusOr<std::string> second = ReadOne(CopyPath());
  if (!first.ok() && !second.ok()) {
    return absl::IsNotFound(first.status()) ? second.status() : first.status();
  }
  // The copy is written last: if both files are valid and differ, a crash occurred between the two
  // writes.
  if (!second.ok() || (first.ok() && *first != *second)) {
    Repair(CopyPath(), *first);
    return first;
  }
  if (!first.ok()) {
    Repair(path_, *second);
    return second;
  }
  return first;
}

absl::StatusOr<std::string> MirroredFile::Inspect(std::vector<std::string>* problems) const {
  absl::StatusOr<std::string> first = ReadOne(path_);
  absl::StatusOr<std::string> second = ReadOne(CopyPath());
  for (const absl::StatusOr<std::string>* value : {&first, &second}) {
    if (!value->ok()) problems->emplace_back(value->status().message());
  }
  return first.ok() ? first : second;
}

absl::Status MirroredFile::Write(std::string_view value) const {
  const std::string packed = Pack(value);
  if (absl::Status status = WriteFileDurably(path_, packed); !status.ok()) return status;
  return WriteFileDurably(CopyPath(), packed);
}

}  // namespace steadymap

#include "server/store/map/map_folder.h"

#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>

#include <absl/random/random.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/stat.h>

#include "core/types/error.h"
#include "server/store/database/store_records.h"
#include "server/store/disk/posix_file.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

constexpr char kIdentityFile[] = "identity";
constexpr char kNoteFile[] = "note";
constexpr char kDeletedMark[] = "deleted";

/// Returns the inode and the birth time of a file, which a copy does not share; none if the file
/// does not exist.
std::optional<storage::v1::FileIdentity> IdentityOf(const std::filesystem::path& file) {
  struct statx info {};

  if (::statx(AT_FDCWD, file.c_str(), 0, STATX_INO | STATX_BTIME, &info) != 0) return std::nullopt;
  storage::v1::FileIdentity identity;
  identity.set_inode(info.stx_ino);
  if ((info.stx_mask & STATX_BTIME) != 0) {
    identity.set_birth_time_ns(info.stx_btime.tv_sec * kNanosecondsPerSecond +
                               info.stx_btime.tv_nsec);
  }
  return identity;
}

absl::Status DamagedRecord(const std::filesystem::path& folder, const char* what) {
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("the record of the map in ", folder.string(), " ", what));
}

/// Parses the content of the record's file.
absl::StatusOr<storage::v1::MapRecord> ReadProto(const absl::StatusOr<std::string>& bytes,
                                                 const std::filesystem::path& folder) {
  if (absl::IsNotFound(bytes.status())) return DamagedRecord(folder, "is missing");
  if (!bytes.ok()) return bytes.status();
  storage::v1::MapRecord proto;
  if (!proto.ParseFromString(*bytes)) return DamagedRecord(folder, "cannot be read");
  return proto;
}

}  // namespace

std::string NewIncarnation() {
  absl::BitGen random;
  return absl::StrCat(absl::Hex(absl::Uniform<std::uint64_t>(random), absl::kZeroPad16));
}

MapFolder::MapFolder(std::filesystem::path path, MapKey key)
    : path_(std::move(path)), key_(key), record_file_(path_ / "record") {}

absl::Status MapFolder::Create(const MapRecord& record) const {
  if (absl::Status status = MakeFolder(path_); !status.ok()) return status;
  if (absl::Status status = WriteFileDurably(path_ / kIdentityFile, "\n"); !status.ok()) {
    return status;
  }
  return WriteRecord(record);
}

absl::StatusOr<MapRecord> MapFolder::ReadRecord() const { return TakeRecord(record_file_.Read()); }

absl::StatusOr<MapRecord> MapFolder::InspectRecord(std::vector<std::string>* problems) const {
  return TakeRecord(record_file_.Inspect(problems));
}

absl::StatusOr<MapRecord> MapFolder::TakeRecord(const absl::StatusOr<std::string>& bytes) const {
  const absl::StatusOr<storage::v1::MapRecord> proto = ReadProto(bytes, path_);
  if (!proto.ok()) return proto.status();
  absl::StatusOr<MapRecord> record = FromProto(*proto);
  if (record.ok() && record->key != key_) return DamagedRecord(path_, "belongs to another map");
  return record;
}

absl::Status MapFolder::WriteRecord(const MapRecord& record) const {
  storage::v1::MapRecord proto = ToProto(record);
  if (const auto identity = IdentityOf(path_ / kIdentityFile))
    *proto.mutable_identity() = *identity;
  return record_file_.Write(proto.SerializeAsString());
}

bool MapFolder::IsCopy() const {
  const absl::StatusOr<storage::v1::MapRecord> proto = ReadProto(record_file_.Read(), path_);
  if (!proto.ok() || !proto->has_identity()) return false;
  const auto identity = IdentityOf(path_ / kIdentityFile);
  return !identity || identity->inode() != proto->identity().inode() ||
         identity->birth_time_ns() != proto->identity().birth_time_ns();
}

absl::StatusOr<MapRecord> MapFolder::Adopt(MapRecord record) const {
  std::error_code error;
  std::filesystem::remove(path_ / kNoteFile, error);
  if (!std::filesystem::exists(path_ / kIdentityFile, error)) {
    if (absl::Status status = WriteFileDurably(path_ / kIdentityFile, "\n"); !status.ok()) {
      return status;
    }
  }
  record.incarnation = NewIncarnation();
  ++record.version;
  if (absl::Status status = WriteRecord(record); !status.ok()) return status;
  return record;
}

absl::Status MapFolder::MarkDeleted() const { return WriteFileDurably(path_ / kDeletedMark, "\n"); }

bool MapFolder::IsDeleted() const {
  std::error_code error;
  return std::filesystem::exists(path_ / kDeletedMark, error);
}

absl::Status MapFolder::Remove() const {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
  return error ? SystemError(error.value(), "remove", path_) : absl::OkStatus();
}

}  // namespace steadymap

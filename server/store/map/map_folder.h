#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/store/disk/mirrored_file.h"
#include "server/store/model/store.h"

namespace steadymap {

/// The folder of one map in the store: `record` (what the map is), `identity` (tells a copy of the
/// folder from the original), `log/`, `state/` and `note` (see `MapDatabase`), and `deleted` once
/// the map is. One thread at a time.
class MapFolder {
 public:
  MapFolder(std::filesystem::path path, MapKey key);

  const std::filesystem::path& path() const { return path_; }

  /// Makes the folder with the record and an identity.
  absl::Status Create(const MapRecord& record) const;

  /// The record. Errors: `DataLoss` with reason `CHECKSUM` for one that is damaged, missing or
  /// another map's.
  absl::StatusOr<MapRecord> ReadRecord() const;

  /// As `ReadRecord`, but changes nothing: what is wrong with its files is added to `problems`.
  absl::StatusOr<MapRecord> InspectRecord(std::vector<std::string>* problems) const;

  absl::Status WriteRecord(const MapRecord& record) const;

  /// Whether the folder is a copy of the one that was written last, as after a restore from a
  /// backup: then its history may go on differently than the original's did. False where nobody can
  /// tell.
  bool IsCopy() const;

  /// Makes a copy an original: the record gets another incarnation, so that nobody goes on behind a
  /// resume token of the original's later history, and what the note knows is forgotten.
  absl::StatusOr<MapRecord> Adopt(MapRecord record) const;

  /// Marks the map as deleted; durable when it returns.
  absl::Status MarkDeleted() const;
  bool IsDeleted() const;

  /// Removes the folder with all it holds.
  absl::Status Remove() const;

 private:
  absl::StatusOr<MapRecord> TakeRecord(const absl::StatusOr<std::string>& bytes) const;

  std::filesystem::path path_;
  MapKey key_;
  MirroredFile record_file_;
};

/// An incarnation that no map has had.
std::string NewIncarnation();

}  // namespace steadymap

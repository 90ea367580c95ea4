#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/store/disk/mirrored_file.h"
#include "server/store/model/store.h"

namespace steadymap {

/// The folder of one map in the store: `record` (the map's record), `identity` (distinguishes a
/// copy of the folder from the original), `log/`, `state/` and `note` (see `MapDatabase`), and
/// `deleted` once the map is deleted. One thread at a time.
class MapFolder {
 public:
  MapFolder(std::filesystem::path path, MapKey key);

  const std::filesystem::path& path() const { return path_; }

  /// Creates the folder with the record and an identity.
  absl::Status Create(const MapRecord& record) const;

  /// Returns the record. Errors: `DataLoss` with reason `CHECKSUM` if the record is damaged,
  /// missing or belongs to another map.
  absl::StatusOr<MapRecord> ReadRecord() const;

  /// Reads as `ReadRecord` does, but changes nothing. Adds each error of the record's files to
  /// `problems`.
  absl::StatusOr<MapRecord> InspectRecord(std::vector<std::string>* problems) const;

  absl::Status WriteRecord(const MapRecord& record) const;

  /// True if the folder is a copy of the folder that was written last, for example after a restore
  /// from a backup. The history of a copy may diverge from the history of the original. False if
  /// this cannot be determined.
  bool IsCopy() const;

  /// Turns a copy into an original. Gives the record a new incarnation, so that a resume token of
  /// the original's later history is rejected, and deletes the note.
  absl::StatusOr<MapRecord> Adopt(MapRecord record) const;

  /// Marks the map as deleted, and syncs the mark.
  absl::Status MarkDeleted() const;
  bool IsDeleted() const;

  /// Removes the folder and its content.
  absl::Status Remove() const;

 private:
  absl::StatusOr<MapRecord> TakeRecord(const absl::StatusOr<std::string>& bytes) const;

  std::filesystem::path path_;
  MapKey key_;
  MirroredFile record_file_;
};

/// Returns a new random incarnation.
std::string NewIncarnation();

}  // namespace steadymap

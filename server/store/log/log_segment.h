#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/types/identifiers.h"
#include "server/store/disk/posix_file.h"
#include "server/store/model/store.h"

/// One file of a map's entry log.
///
/// Layout, little-endian. A segment header (48 bytes): magic "SMAPLOG1", u64 map key, u64 sequence
/// of the first entry, u64 number of the first group, i64 uptime of the map when it was made (ns),
/// u32 CRC-32C of all that, u32 zero. Then records, each a header (32 bytes) and a payload that is
/// filled up with zeros to a multiple of 8 bytes. Record header: u32 magic "SMLG", u32 CRC-32C of
/// the map key and the following 24 bytes, u32 CRC-32C of the payload, u32 length of the payload,
/// u64 number (of the entry, or of the group), u8 kind, 7 zero bytes.
///
/// Records are written in groups: entries, then one `kGroupEnd`. A group is synced as a whole, and
/// counts only if its end is there: what a crash left of a group without its end was never
/// acknowledged.
namespace steadymap {

/// What a record of the log holds.
enum class LogRecordKind : std::uint8_t {
  kFrame = 1,     ///< An entry: a frame, with its source.
  kClasses = 2,   ///< An entry: classes that the map's table gains.
  kGroupEnd = 3,  ///< The end of a group, with the sessions that it changed.
  kSkipped = 4,   ///< An entry without effect and without payload.
};

/// Where a segment begins.
struct SegmentStart {
  MapKey map;
  MapSequence first_entry;
  std::uint64_t first_group = 0;
  MapUptime uptime{0};
};

/// A record on its way into a segment. The payload's parts are written one after another.
struct LogRecord {
  LogRecordKind kind = LogRecordKind::kFrame;
  std::uint64_t number = 0;
  std::vector<std::string_view> payload{};
};

/// Writes one segment. After an error other than `DISK_LOW` nothing more may be written: what is on
/// disk is no longer known.
class LogSegmentWriter {
 public:
  /// Makes the file, which must not exist; it is on disk when this returns.
  static absl::StatusOr<LogSegmentWriter> Create(const std::filesystem::path& path,
                                                 const SegmentStart& start);

  /// Goes on behind the `size` bytes of a segment that is whole.
  static absl::StatusOr<LogSegmentWriter> Reopen(const std::filesystem::path& path,
                                                 std::uint64_t size);

  /// Gives back disk space that was taken for appends to come.
  ~LogSegmentWriter();
  LogSegmentWriter(LogSegmentWriter&& other) noexcept;
  LogSegmentWriter& operator=(LogSegmentWriter&& other) noexcept;

  /// Appends a group, `records` with their end last, and syncs it.
  /// Errors: `ResourceExhausted` with reason `DISK_LOW`: nothing was written. `Unavailable` with
  /// reason `STORE_READ_ONLY`: see above.
  absl::Status Append(const std::vector<LogRecord>& records, MapKey map);

  /// Bytes of the file.
  std::uint64_t size() const { return size_; }

 private:
  LogSegmentWriter(PosixFile file, std::uint64_t size);

  absl::Status TakeSpace(std::uint64_t bytes);
  void GiveSpaceBack();

  PosixFile file_;
  std::uint64_t size_ = 0;
  std::uint64_t space_end_ = 0;  ///< Up to where the disk has space for the file.
};

/// A record as it was found in a segment.
struct FoundRecord {
  LogRecordKind kind = LogRecordKind::kFrame;
  std::uint64_t number = 0;
  std::string payload;  ///< Empty where it was not asked for.
};

/// Reads the records of one segment in their order.
class LogSegmentReader {
 public:
  /// Errors: as `PosixFile::Open`; `DataLoss` with reason `CHECKSUM` for a header that is damaged
  /// or another map's.
  static absl::StatusOr<LogSegmentReader> Open(const std::filesystem::path& path, MapKey map);

  const SegmentStart& start() const { return start_; }

  /// The next record; none at the end of the file. `wants_payload` says of which kinds and numbers
  /// the payload is read. Errors: `DataLoss` with reason `CHECKSUM`, naming file and place.
  absl::StatusOr<std::optional<FoundRecord>> Next(
      const std::function<bool(LogRecordKind, std::uint64_t)>& wants_payload);

 private:
  LogSegmentReader(PosixFile file, SegmentStart start, std::uint64_t size);

  PosixFile file_;
  SegmentStart start_;
  std::uint64_t size_ = 0;
  std::uint64_t place_ = 0;
};

/// What a scan of a whole segment found.
struct SegmentScan {
  SegmentStart start;
  std::uint64_t end = 0;         ///< Of the last group that is complete: bytes from the start.
  std::uint64_t file_bytes = 0;  ///< More than `end` if a group was torn by a crash.
  MapSequence last_entry;        ///< Of the last complete group; the one before the first if none.
  std::uint64_t last_group = 0;  ///< Likewise.
  std::vector<FoundRecord> ends{};     ///< The group ends, in their order.
  std::vector<FoundRecord> classes{};  ///< The entries of this kind, in their order.
};

/// Reads a whole segment and checks every byte. `may_be_torn`: it is the newest, so what follows
/// its last complete group may be a write that a crash interrupted; see `FindTornEnd` for what
/// tells it from damage. Errors: `DataLoss` with reason `CHECKSUM`, naming file and place.
absl::StatusOr<SegmentScan> ScanSegment(const std::filesystem::path& path,
                                        MapKey map,
                                        bool may_be_torn);

/// A whole record in a file that may be damaged elsewhere.
struct WholeRecord {
  FoundRecord record;
  std::uint64_t place = 0;  ///< Bytes from the start of the file.
};

/// Every record of a segment whose header and payload match their checksums, in the order of their
/// places, whatever stands between them. Errors: as `ReadWholeFile`.
absl::StatusOr<std::vector<WholeRecord>> FindWholeRecords(const std::filesystem::path& path,
                                                          MapKey map);

}  // namespace steadymap

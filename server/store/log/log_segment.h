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
/// of the first entry, u64 number of the first group, i64 uptime of the map at the creation of the
/// file (ns), u32 CRC-32C of all preceding bytes, u32 zero. Then records, each a header (32 bytes)
/// and a payload that is zero-padded to a multiple of 8 bytes. Record header: u32 magic "SMLG", u32
/// CRC-32C of the map key and the following 24 bytes, u32 CRC-32C of the payload, u32 length of the
/// payload, u64 number (of the entry, or of the group), u8 kind, 7 zero bytes.
///
/// Records are written in groups: entries, then one `kGroupEnd`. A group is synced as a whole, and
/// is valid only if its end exists: a group without an end, left by a crash, was never
/// acknowledged.
namespace steadymap {

/// The kind of a record of the log.
enum class LogRecordKind : std::uint8_t {
  kFrame = 1,       ///< An entry: a frame, with its source.
  kClasses = 2,     ///< An entry: classes added to the map's class table.
  kGroupEnd = 3,    ///< The end of a group, with the sessions that it changed.
  kSkipped = 4,     ///< An entry without effect and without payload.
  kSessionEnd = 5,  ///< An entry: the session of a robot has ended.
};

/// The content of a segment's header.
struct SegmentStart {
  MapKey map;
  MapSequence first_entry;
  std::uint64_t first_group = 0;
  MapUptime uptime{0};
};

/// A record to be written to a segment. The parts of the payload are written consecutively.
struct LogRecord {
  LogRecordKind kind = LogRecordKind::kFrame;
  std::uint64_t number = 0;
  std::vector<std::string_view> payload{};
};

/// Writes one segment. After an error other than `DISK_LOW` no further write is allowed, because
/// the content on disk is unknown.
class LogSegmentWriter {
 public:
  /// Creates the file, which must not exist, and syncs it.
  static absl::StatusOr<LogSegmentWriter> Create(const std::filesystem::path& path,
                                                 const SegmentStart& start);

  /// Continues a complete segment of `size` bytes.
  static absl::StatusOr<LogSegmentWriter> Reopen(const std::filesystem::path& path,
                                                 std::uint64_t size);

  /// Releases disk space that was reserved for later appends.
  ~LogSegmentWriter();
  LogSegmentWriter(LogSegmentWriter&& other) noexcept;
  LogSegmentWriter& operator=(LogSegmentWriter&& other) noexcept;

  /// Appends a group and syncs it. The last of `records` is the end of the group. Errors:
  /// `ResourceExhausted` with reason `DISK_LOW`: nothing was written. `Unavailable` with reason
  /// `STORE_READ_ONLY`: no further write is allowed.
  absl::Status Append(const std::vector<LogRecord>& records, MapKey map);

  /// Returns the size of the file in bytes.
  std::uint64_t size() const { return size_; }

 private:
  LogSegmentWriter(PosixFile file, std::uint64_t size);

  absl::Status ReserveSpace(std::uint64_t bytes);
  void ReleaseSpace();

  PosixFile file_;
  std::uint64_t size_ = 0;
  std::uint64_t reserved_end_ = 0;  ///< End of the disk space reserved for the file.
};

/// A record read from a segment.
struct FoundRecord {
  LogRecordKind kind = LogRecordKind::kFrame;
  std::uint64_t number = 0;
  std::string payload;  ///< Empty if it was not requested.
};

/// Reads the records of one segment in their order.
class LogSegmentReader {
 public:
  /// Opens a segment. Errors: as `PosixFile::Open`; `DataLoss` with reason `CHECKSUM` if the header
  /// is damaged or belongs to another map.
  static absl::StatusOr<LogSegmentReader> Open(const std::filesystem::path& path, MapKey map);

  const SegmentStart& start() const { return start_; }

  /// Returns the next record; none at the end of the file. Reads the payload only of records for
  /// which `needs_payload` returns true, given kind and number. Errors: `DataLoss` with reason
  /// `CHECKSUM`, with file and offset in the message.
  absl::StatusOr<std::optional<FoundRecord>> Next(
      const std::function<bool(LogRecordKind, std::uint64_t)>& needs_payload);

 private:
  LogSegmentReader(PosixFile file, SegmentStart start, std::uint64_t size);

  PosixFile file_;
  SegmentStart start_;
  std::uint64_t size_ = 0;
  std::uint64_t place_ = 0;
};

/// The result of a scan of a whole segment.
struct SegmentScan {
  SegmentStart start;
  std::uint64_t end = 0;  ///< End of the last complete group: bytes from the start of the file.
  std::uint64_t file_bytes = 0;  ///< Greater than `end` if a crash interrupted a group.
  /// Last entry of the last complete group; without one, the entry before the first.
  MapSequence last_entry;
  std::uint64_t last_group = 0;  ///< Last complete group; without one, the group before the first.
  std::vector<FoundRecord> ends{};     ///< The group ends, in log order.
  std::vector<FoundRecord> classes{};  ///< The entries of kind `kClasses`, in log order.
};

/// Reads a whole segment and verifies every byte. `may_be_torn`: the segment is the newest, so the
/// bytes after its last complete group may be a write interrupted by a crash; see `HasZeroSector`
/// for the distinction from damage. Errors: `DataLoss` with reason `CHECKSUM`, with file and offset
/// in the message.
absl::StatusOr<SegmentScan> ScanSegment(const std::filesystem::path& path,
                                        MapKey map,
                                        bool may_be_torn);

/// An intact record in a file that may be damaged elsewhere.
struct IntactRecord {
  FoundRecord record;
  std::uint64_t place = 0;  ///< Offset in bytes from the start of the file.
};

/// Returns every record of a segment whose header and payload match their checksums, in the order
/// of their offsets, regardless of the bytes between them. Errors: as `ReadWholeFile`.
absl::StatusOr<std::vector<IntactRecord>> FindIntactRecords(const std::filesystem::path& path,
                                                            MapKey map);

}  // namespace steadymap

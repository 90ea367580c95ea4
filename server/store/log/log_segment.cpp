#include "server/store/log/log_segment.h"

#include <algorithm>
#include <array>
#include <utility>

#include <absl/strings/str_cat.h>
#include <fcntl.h>

#include "core/types/crc32c.h"
#include "core/types/error.h"
#include "server/store/disk/torn_tail_write.h"

namespace steadymap {
namespace {

constexpr std::string_view kSegmentMagic = "SMAPLOG1";
constexpr std::string_view kRecordMagic = "SMLG";
constexpr std::size_t kSegmentHeaderBytes = 48;
constexpr std::size_t kSegmentSummedBytes = 40;
constexpr std::size_t kRecordHeaderBytes = 32;
constexpr std::size_t kRecordSummedBytes = 24;
constexpr std::size_t kAlignment = 8;
// Largest disk space reserved for later appends. The reservation is also limited to the size of the
// segment, so that the files of small maps stay small.
constexpr std::uint64_t kMaxSpaceAhead = std::uint64_t{4} << 20;

constexpr std::string_view kPadding{"\0\0\0\0\0\0\0", kAlignment - 1};

void AppendInteger(std::uint64_t value, std::size_t bytes, std::string* text) {
  for (std::size_t i = 0; i < bytes; ++i) text->push_back(static_cast<char>(value >> (8 * i)));
}

std::uint64_t ReadInteger(std::string_view text, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    value |= std::uint64_t{static_cast<unsigned char>(text[at + i])} << (8 * i);
  }
  return value;
}

std::uint32_t HeaderChecksum(MapKey map, std::string_view summed) {
  std::string key;
  AppendInteger(map.value(), sizeof(std::uint64_t), &key);
  return ExtendCrc32c(ExtendCrc32c(0, key), summed);
}

std::string PackSegmentHeader(const SegmentStart& start) {
  std::string header(kSegmentMagic);
  AppendInteger(start.map.value(), 8, &header);
  AppendInteger(start.first_entry.value(), 8, &header);
  AppendInteger(start.first_group, 8, &header);
  AppendInteger(static_cast<std::uint64_t>(start.uptime.count()), 8, &header);
  AppendInteger(ExtendCrc32c(0, header), 4, &header);
  AppendInteger(0, 4, &header);
  return header;
}

std::optional<SegmentStart> UnpackSegmentHeader(std::string_view header) {
  if (header.size() < kSegmentHeaderBytes || !header.starts_with(kSegmentMagic)) {
    return std::nullopt;
  }
  const std::string_view summed = header.substr(0, kSegmentSummedBytes);
  if (ReadInteger(header, kSegmentSummedBytes, 4) != ExtendCrc32c(0, summed)) return std::nullopt;
  return SegmentStart{MapKey(ReadInteger(header, 8, 8)),
                      MapSequence(ReadInteger(header, 16, 8)),
                      ReadInteger(header, 24, 8),
                      MapUptime(static_cast<std::int64_t>(ReadInteger(header, 32, 8)))};
}

/// The header of a record.
struct RecordHeader {
  LogRecordKind kind = LogRecordKind::kFrame;
  std::uint64_t number = 0;
  std::uint64_t payload_bytes = 0;
  std::uint32_t payload_crc = 0;

  /// Returns the size of the whole record in bytes, with padding.
  std::uint64_t record_bytes() const {
    return kRecordHeaderBytes + (payload_bytes + kAlignment - 1) / kAlignment * kAlignment;
  }
};

std::string PackRecordHeader(const RecordHeader& header, MapKey map) {
  std::string summed;
  AppendInteger(header.payload_crc, 4, &summed);
  AppendInteger(header.payload_bytes, 4, &summed);
  AppendInteger(header.number, 8, &summed);
  AppendInteger(static_cast<std::uint64_t>(header.kind), 8, &summed);
  std::string packed(kRecordMagic);
  AppendInteger(HeaderChecksum(map, summed), 4, &packed);
  return packed + summed;
}

std::optional<RecordHeader> UnpackRecordHeader(std::string_view packed, MapKey map) {
  if (packed.size() < kRecordHeaderBytes || !packed.starts_with(kRecordMagic)) return std::nullopt;
  const std::string_view summed = packed.substr(8, kRecordSummedBytes);
  if (ReadInteger(packed, 4, 4) != HeaderChecksum(map, summed)) return std::nullopt;
  const std::uint64_t kind = ReadInteger(packed, 24, 8);
  if (kind < 1 || kind > static_cast<std::uint64_t>(LogRecordKind::kSessionEnd))
    return std::nullopt;
  return RecordHeader{static_cast<LogRecordKind>(kind),
                      ReadInteger(packed, 16, 8),
                      ReadInteger(packed, 12, 4),
                      static_cast<std::uint32_t>(ReadInteger(packed, 8, 4))};
}

absl::Status Damaged(const std::filesystem::path& path, std::uint64_t place) {
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("log file ", path.string(), " is damaged at byte ", place));
}

/// True if the bytes behind `end`, the end of the last complete group, are one write that a crash
/// interrupted: at least one sector is missing, and no other group begins or ends there.
bool IsTorn(std::string_view segment, const SegmentScan& scan) {
  if (!HasZeroSector(segment, scan.end)) return false;
  bool group_ended = false;
  for (std::uint64_t place = scan.end; place + kRecordHeaderBytes <= segment.size();) {
    const std::optional<RecordHeader> header =
        UnpackRecordHeader(segment.substr(place, kRecordHeaderBytes), scan.start.map);
    if (!header) {
      place += kAlignment;
      continue;
    }
    if (group_ended) return false;
    if (header->kind == LogRecordKind::kGroupEnd) {
      if (header->number != scan.last_group + 1) return false;
      group_ended = true;
    }
    place += std::min<std::uint64_t>(header->record_bytes(), segment.size() - place);
  }
  return true;
}

/// Builds a scan of a segment, record by record.
class SegmentWalk {
 public:
  SegmentWalk(std::string_view segment, SegmentScan* scan)
      : segment_(segment), scan_(scan), place_(kSegmentHeaderBytes) {}

  enum class Step { kRecord, kEnd, kCut, kDamaged };

  /// Reads the next record. `kCut`: the file ends within it.
  Step Next() {
    if (place_ == segment_.size()) return Step::kEnd;
    if (place_ + kRecordHeaderBytes > segment_.size()) return Step::kCut;
    const std::optional<RecordHeader> header =
        UnpackRecordHeader(segment_.substr(place_, kRecordHeaderBytes), scan_->start.map);
    if (!header) return Step::kDamaged;
    if (place_ + header->record_bytes() > segment_.size()) return Step::kCut;
    const std::string_view payload =
        segment_.substr(place_ + kRecordHeaderBytes, header->payload_bytes);
    if (ExtendCrc32c(0, payload) != header->payload_crc || !Follows(*header)) {
      return Step::kDamaged;
    }
    place_ += header->record_bytes();
    Take(*header, payload);
    return Step::kRecord;
  }

  std::uint64_t place() const { return place_; }

 private:
  bool Follows(const RecordHeader& header) const {
    return header.kind == LogRecordKind::kGroupEnd
               ? header.number == scan_->last_group + 1
               : header.number == scan_->last_entry.value() + entries_.size() + 1;
  }

  void Take(const RecordHeader& header, std::string_view payload) {
    if (header.kind != LogRecordKind::kGroupEnd) {
      entries_.push_back({header.kind, header.number, {}});
      if (header.kind == LogRecordKind::kClasses) entries_.back().payload = payload;
      return;
    }
    scan_->last_entry = MapSequence(scan_->last_entry.value() + entries_.size());
    for (FoundRecord& entry : entries_) {
      if (entry.kind == LogRecordKind::kClasses) scan_->classes.push_back(std::move(entry));
    }
    entries_.clear();
    scan_->last_group = header.number;
    scan_->ends.push_back({header.kind, header.number, std::string(payload)});
    scan_->end = place_;
  }

  std::string_view segment_;
  SegmentScan* scan_;
  std::uint64_t place_;
  std::vector<FoundRecord> entries_;  ///< Entries of the group whose end was not read yet.
};

}  // namespace

LogSegmentWriter::LogSegmentWriter(PosixFile file, std::uint64_t size)
    : file_(std::move(file)), size_(size), reserved_end_(size) {}

LogSegmentWriter::~LogSegmentWriter() { ReleaseSpace(); }

LogSegmentWriter::LogSegmentWriter(LogSegmentWriter&& other) noexcept
    : file_(std::move(other.file_)),
      size_(other.size_),
      reserved_end_(std::exchange(other.reserved_end_, 0)) {}

LogSegmentWriter& LogSegmentWriter::operator=(LogSegmentWriter&& other) noexcept {
  ReleaseSpace();
  file_ = std::move(other.file_);
  size_ = other.size_;
  reserved_end_ = std::exchange(other.reserved_end_, 0);
  return *this;
}

/// Reserves more than is needed as the segment grows, because an allocation with each sync makes
/// the sync a fifth slower.
absl::Status LogSegmentWriter::ReserveSpace(std::uint64_t bytes) {
  const std::uint64_t end = size_ + bytes;
  if (end <= reserved_end_) return absl::OkStatus();
  const std::uint64_t ahead = std::min(size_, kMaxSpaceAhead);
  if (file_.Reserve(size_, bytes + ahead).ok()) {
    reserved_end_ = end + ahead;
    return absl::OkStatus();
  }
  absl::Status status = file_.Reserve(size_, bytes);
  if (status.ok()) reserved_end_ = end;
  return status;
}

void LogSegmentWriter::ReleaseSpace() {
  if (reserved_end_ > size_) file_.Truncate(size_).IgnoreError();
  reserved_end_ = 0;
}

absl::StatusOr<LogSegmentWriter> LogSegmentWriter::Create(const std::filesystem::path& path,
                                                          const SegmentStart& start) {
  // Written under a temporary name first, so that a crash leaves no segment without its header.
  const std::string header = PackSegmentHeader(start);
  if (absl::Status status = WriteFileDurably(path, header); !status.ok()) return status;
  return Reopen(path, header.size());
}

absl::StatusOr<LogSegmentWriter> LogSegmentWriter::Reopen(const std::filesystem::path& path,
                                                          std::uint64_t size) {
  absl::StatusOr<PosixFile> file = PosixFile::Open(path, O_WRONLY);
  if (!file.ok()) return file.status();
  return LogSegmentWriter(*std::move(file), size);
}

absl::Status LogSegmentWriter::Append(const std::vector<LogRecord>& records, MapKey map) {
  std::vector<std::string> headers;
  headers.reserve(records.size());
  std::vector<std::string_view> parts;
  std::uint64_t bytes = 0;
  for (const LogRecord& record : records) {
    RecordHeader header{record.kind, record.number, 0, 0};
    for (const std::string_view part : record.payload) {
      header.payload_bytes += part.size();
      header.payload_crc = ExtendCrc32c(header.payload_crc, part);
    }
    parts.emplace_back(headers.emplace_back(PackRecordHeader(header, map)));
    parts.insert(parts.end(), record.payload.begin(), record.payload.end());
    parts.push_back(
        kPadding.substr(0, header.record_bytes() - kRecordHeaderBytes - header.payload_bytes));
    bytes += header.record_bytes();
  }
  if (absl::Status status = ReserveSpace(bytes); !status.ok()) return status;
  absl::Status status = file_.WriteAt(size_, parts);
  if (status.ok()) status = file_.Sync();
  if (status.ok()) {
    size_ += bytes;
    return status;
  }
  const absl::Status cut = file_.Truncate(size_);
  reserved_end_ = size_;
  if (cut.ok() && ReasonOf(status) == reason::kDiskLow) return status;
  return MakeError(absl::StatusCode::kUnavailable,
                   reason::kStoreReadOnly,
                   absl::StrCat("the log accepts no more frames: ", status.message()));
}

LogSegmentReader::LogSegmentReader(PosixFile file, SegmentStart start, std::uint64_t size)
    : file_(std::move(file)), start_(start), size_(size), place_(kSegmentHeaderBytes) {}

absl::StatusOr<LogSegmentReader> LogSegmentReader::Open(const std::filesystem::path& path,
                                                        MapKey map) {
  absl::StatusOr<PosixFile> file = PosixFile::Open(path, O_RDONLY);
  if (!file.ok()) return file.status();
  const absl::StatusOr<std::uint64_t> size = file->Size();
  if (!size.ok()) return size.status();
  const absl::StatusOr<std::string> header = file->ReadAt(0, kSegmentHeaderBytes);
  if (!header.ok()) return header.status();
  const std::optional<SegmentStart> start = UnpackSegmentHeader(*header);
  if (!start || start->map != map) return Damaged(path, 0);
  return LogSegmentReader(*std::move(file), *start, *size);
}

absl::StatusOr<std::optional<FoundRecord>> LogSegmentReader::Next(
    const std::function<bool(LogRecordKind, std::uint64_t)>& needs_payload) {
  if (place_ >= size_) return std::optional<FoundRecord>();
  const absl::StatusOr<std::string> packed = file_.ReadAt(place_, kRecordHeaderBytes);
  if (!packed.ok()) return packed.status();
  const std::optional<RecordHeader> header = UnpackRecordHeader(*packed, start_.map);
  if (!header || place_ + header->record_bytes() > size_) return Damaged(file_.path(), place_);
  FoundRecord record{header->kind, header->number, {}};
  if (needs_payload(record.kind, record.number)) {
    absl::StatusOr<std::string> payload =
        file_.ReadAt(place_ + kRecordHeaderBytes, header->payload_bytes);
    if (!payload.ok()) return payload.status();
    if (ExtendCrc32c(0, *payload) != header->payload_crc) return Damaged(file_.path(), place_);
    record.payload = *std::move(payload);
  }
  place_ += header->record_bytes();
  return std::optional<FoundRecord>(std::move(record));
}

absl::StatusOr<SegmentScan> ScanSegment(const std::filesystem::path& path,
                                        MapKey map,
                                        bool may_be_torn) {
  const absl::StatusOr<std::string> segment = ReadWholeFile(path);
  if (!segment.ok()) return segment.status();
  const std::optional<SegmentStart> start = UnpackSegmentHeader(*segment);
  if (!start || start->map != map || start->first_entry.value() == 0 || start->first_group == 0) {
    return Damaged(path, 0);
  }
  SegmentScan scan;
  scan.start = *start;
  scan.end = kSegmentHeaderBytes;
  scan.file_bytes = segment->size();
  scan.last_entry = MapSequence(start->first_entry.value() - 1);
  scan.last_group = start->first_group - 1;
  SegmentWalk walk(*segment, &scan);
  SegmentWalk::Step step = SegmentWalk::Step::kRecord;
  while (step == SegmentWalk::Step::kRecord) step = walk.Next();
  const bool whole = step == SegmentWalk::Step::kEnd && scan.end == segment->size();
  const bool cut = step != SegmentWalk::Step::kDamaged;
  if (whole || (may_be_torn && (cut || IsTorn(*segment, scan)))) return scan;
  return Damaged(path, walk.place());
}

absl::StatusOr<std::vector<IntactRecord>> FindIntactRecords(const std::filesystem::path& path,
                                                            MapKey map) {
  const absl::StatusOr<std::string> bytes = ReadWholeFile(path);
  if (!bytes.ok()) return bytes.status();
  const std::string_view segment = *bytes;
  std::vector<IntactRecord> found;
  std::uint64_t place = kSegmentHeaderBytes;
  while (place + kRecordHeaderBytes <= segment.size()) {
    const std::optional<RecordHeader> header =
        UnpackRecordHeader(segment.substr(place, kRecordHeaderBytes), map);
    const std::string_view payload =
        header ? segment.substr(place + kRecordHeaderBytes, header->payload_bytes)
               : std::string_view();
    const bool is_whole = header && payload.size() == header->payload_bytes &&
                          ExtendCrc32c(0, payload) == header->payload_crc;
    if (is_whole) {
      found.push_back({{header->kind, header->number, std::string(payload)}, place});
    }
    place += is_whole ? header->record_bytes() : kAlignment;
  }
  return found;
}

}  // namespace steadymap

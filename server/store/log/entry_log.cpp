#include "server/store/log/entry_log.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <fcntl.h>
#include <spdlog/spdlog.h>

#include "core/types/error.h"
#include "server/store/database/store_records.h"
#include "server/store/disk/posix_file.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

constexpr char kExtension[] = ".log";

// Size of the length field before the header of a frame.
constexpr std::size_t kHeaderLengthBytes = 4;

absl::Status MissingEntry(MapKey map, MapSequence sequence) {
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("the log of map ", map.value(), " lacks entry ", sequence.value()));
}

absl::Status UnreadableEntry(std::uint64_t number) {
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("entry ", number, " of the log cannot be decoded"));
}

LogRecordKind RecordKindOf(LogEntryKind kind) {
  switch (kind) {
    case LogEntryKind::kFrame:
      return LogRecordKind::kFrame;
    case LogEntryKind::kClasses:
      return LogRecordKind::kClasses;
    case LogEntryKind::kSkipped:
      return LogRecordKind::kSkipped;
    case LogEntryKind::kSessionEnd:
      return LogRecordKind::kSessionEnd;
  }
  return LogRecordKind::kSkipped;
}

std::string PackGroupEnd(const LogAppend& append) {
  storage::v1::LogGroup group;
  group.set_uptime_ns(append.uptime.count());
  for (const SessionRecord& session : append.sessions) *group.add_sessions() = ToProto(session);
  return group.SerializeAsString();
}

absl::Status TakeGroupEnd(const FoundRecord& end, EntryLog::Found* found) {
  storage::v1::LogGroup group;
  if (!group.ParseFromString(end.payload)) return UnreadableEntry(end.number);
  found->uptime = std::max(found->uptime, MapUptime(group.uptime_ns()));
  for (const storage::v1::SessionRecord& proto : group.sessions()) {
    absl::StatusOr<SessionRecord> session = FromProto(proto);
    if (!session.ok()) return session.status();
    found->sessions.insert_or_assign(session->name, *session);
  }
  return absl::OkStatus();
}

}  // namespace

std::vector<std::string_view> PackEntry(const LogEntry& entry, std::string* header) {
  if (entry.kind == LogEntryKind::kSkipped) return {};
  if (entry.kind == LogEntryKind::kClasses) {
    storage::v1::ClassTable table;
    for (const SemanticClass& row : entry.classes) *table.add_classes() = ToProto(row);
    *header = table.SerializeAsString();
    return {*header};
  }
  storage::v1::FrameHeader frame;
  frame.set_robot(entry.source.robot);
  frame.set_sensor(entry.source.sensor);
  const std::string packed = frame.SerializeAsString();
  if (entry.kind == LogEntryKind::kSessionEnd) {
    *header = packed;
    return {*header};
  }
  header->clear();
  for (std::size_t i = 0; i < kHeaderLengthBytes; ++i) {
    header->push_back(static_cast<char>(packed.size() >> (8 * i)));
  }
  header->append(packed);
  return {*header, entry.packed_frame};
}

absl::StatusOr<LogEntry> UnpackEntry(FoundRecord record) {
  LogEntry entry;
  entry.sequence = MapSequence(record.number);
  if (record.kind == LogRecordKind::kSkipped) {
    entry.kind = LogEntryKind::kSkipped;
    return entry;
  }
  if (record.kind == LogRecordKind::kClasses) {
    entry.kind = LogEntryKind::kClasses;
    storage::v1::ClassTable table;
    if (!table.ParseFromString(record.payload)) return UnreadableEntry(record.number);
    for (const storage::v1::SemanticClass& row : table.classes()) {
      absl::StatusOr<SemanticClass> read = FromProto(row);
      if (!read.ok()) return read.status();
      entry.classes.push_back(*std::move(read));
    }
    return entry;
  }
  if (record.kind == LogRecordKind::kSessionEnd) {
    entry.kind = LogEntryKind::kSessionEnd;
    storage::v1::FrameHeader source;
    if (!source.ParseFromString(record.payload)) return UnreadableEntry(record.number);
    entry.source = {source.robot(), source.sensor()};
    return entry;
  }
  std::size_t header_bytes = 0;
  if (record.payload.size() < kHeaderLengthBytes) return UnreadableEntry(record.number);
  for (std::size_t i = 0; i < kHeaderLengthBytes; ++i) {
    header_bytes |= std::size_t{static_cast<unsigned char>(record.payload[i])} << (8 * i);
  }
  storage::v1::FrameHeader frame;
  if (record.payload.size() - kHeaderLengthBytes < header_bytes ||
      !frame.ParseFromArray(record.payload.data() + kHeaderLengthBytes,
                            static_cast<int>(header_bytes))) {
    return UnreadableEntry(record.number);
  }
  entry.source = {frame.robot(), frame.sensor()};
  record.payload.erase(0, kHeaderLengthBytes + header_bytes);
  entry.packed_frame = std::move(record.payload);
  return entry;
}

EntryLog::EntryLog(std::filesystem::path folder, MapKey map, std::uint64_t segment_bytes)
    : folder_(std::move(folder)), map_(map), segment_bytes_(segment_bytes) {}

absl::StatusOr<std::unique_ptr<EntryLog>> EntryLog::Open(const std::filesystem::path& folder,
                                                         MapKey map,
                                                         const Known& known,
                                                         std::uint64_t segment_bytes,
                                                         bool read_only,
                                                         Found* found) {
  std::unique_ptr<EntryLog> log(new EntryLog(folder, map, segment_bytes));
  if (!read_only) {
    if (absl::Status status = MakeFolder(folder); !status.ok()) return status;
  }
  if (absl::Status status = log->ListSegments(); !status.ok()) return status;
  {
    const absl::MutexLock lock(&log->mutex_);
    log->head_ = known.head;
    log->group_ = known.group;
    if (read_only) {
      log->health_ = MakeError(absl::StatusCode::kResourceExhausted,
                               reason::kDiskLow,
                               "the map is open read-only until the disk has free space");
    }
  }
  if (absl::Status status = log->ScanTail(known, read_only, found); !status.ok()) return status;
  return log;
}

/// Lists the log files and reads their headers.
absl::Status EntryLog::ListSegments() {
  const absl::MutexLock lock(&mutex_);
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, error)) {
    if (entry.path().extension() != kExtension) continue;
    const std::string stem = entry.path().stem().string();
    std::uint64_t first_group = 0;
    std::from_chars(stem.data(), stem.data() + stem.size(), first_group);
    absl::StatusOr<LogSegmentReader> reader = LogSegmentReader::Open(entry.path(), map_);
    if (!reader.ok()) return reader.status();
    if (reader->start().first_group != first_group) {
      return MakeError(
          absl::StatusCode::kDataLoss,
          reason::kChecksum,
          absl::StrCat(
              "log file ", entry.path().string(), " has a name that does not match its content"));
    }
    const std::uintmax_t bytes = entry.file_size(error);
    if (error) return SystemError(error.value(), "read the size of", entry.path());
    segments_.push_back({reader->start(), bytes});
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    return SystemError(error.value(), "list", folder_);
  }
  std::sort(segments_.begin(), segments_.end(), [](const Segment& a, const Segment& b) {
    return a.start.first_group < b.start.first_group;
  });
  return absl::OkStatus();
}

/// Reads the files with records newer than `known`, and finds the end of the log.
absl::Status EntryLog::ScanTail(const Known& known, bool read_only, Found* found) {
  MapSequence last_entry;
  const absl::MutexLock lock(&mutex_);
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const bool is_newest = i + 1 == segments_.size();
    if (!is_newest) {
      const SegmentStart& next = segments_[i + 1].start;
      const bool is_known = next.first_group <= known.group + 1 &&
                            next.first_entry.value() <= known.revision.value() + 1;
      if (is_known) continue;
    }
    absl::StatusOr<SegmentScan> scan = ScanSegment(PathOf(segments_[i].start), map_, is_newest);
    if (!scan.ok()) return scan.status();
    if (!is_newest && segments_[i + 1].start.first_entry != scan->last_entry.Next()) {
      return MissingEntry(map_, scan->last_entry.Next());
    }
    for (const FoundRecord& end : scan->ends) {
      if (end.number <= known.group) continue;
      if (absl::Status status = TakeGroupEnd(end, found); !status.ok()) return status;
    }
    for (FoundRecord& classes : scan->classes) {
      if (classes.number <= known.revision.value()) continue;
      absl::StatusOr<LogEntry> entry = UnpackEntry(std::move(classes));
      if (!entry.ok()) return entry.status();
      found->classes.push_back(*std::move(entry));
    }
    if (!is_newest) continue;
    last_entry = scan->last_entry;
    head_ = std::max(head_, scan->last_entry);
    group_ = std::max(group_, scan->last_group);
    segments_[i].bytes = scan->end;
    // A file that ends before the recorded head gets no more entries, because they would not follow
    // it.
    const bool goes_on = scan->last_entry == head_ && scan->last_group == group_;
    if (read_only) continue;
    if (absl::Status status = CutTornGroup(*scan); !status.ok()) return status;
    if (!goes_on) continue;
    absl::StatusOr<LogSegmentWriter> writer =
        LogSegmentWriter::Reopen(PathOf(segments_[i].start), scan->end);
    if (!writer.ok()) return writer.status();
    writer_ = *std::move(writer);
  }
  newest_uptime_ = found->uptime;
  // Every entry that is not integrated must exist, up to the head recorded in the database.
  if (last_entry < known.head && known.head.value() > known.revision.value()) {
    return MissingEntry(map_, std::max(last_entry, MapSequence(known.revision.value())).Next());
  }
  return absl::OkStatus();
}

absl::Status EntryLog::CutTornGroup(const SegmentScan& scan) {
  if (scan.end == scan.file_bytes) return absl::OkStatus();
  const std::filesystem::path path = PathOf(scan.start);
  const absl::StatusOr<PosixFile> file = PosixFile::Open(path, O_WRONLY);
  if (!file.ok()) return file.status();
  if (absl::Status status = file->Truncate(scan.end); !status.ok()) return status;
  if (absl::Status status = file->Sync(); !status.ok()) return status;
  spdlog::warn("dropped {} bytes of a write that was interrupted before it was durable: {}",
               scan.file_bytes - scan.end,
               path.string());
  return absl::OkStatus();
}

absl::Status EntryLog::CheckSequence(const LogAppend& append) const {
  MapSequence last = head();
  for (const LogEntry& entry : append.entries) {
    if (entry.sequence != last.Next()) {
      return absl::FailedPreconditionError(absl::StrCat("entry ",
                                                        entry.sequence.value(),
                                                        " does not follow entry ",
                                                        last.value(),
                                                        " of map ",
                                                        map_.value()));
    }
    last = entry.sequence;
  }
  for (const SessionRecord& session : append.sessions) {
    const SessionName& name = session.name;
    if (!IsValidId(name.sensor.robot) || !IsValidId(name.sensor.sensor) ||
        !IsValidId(name.session)) {
      return InvalidField(
          reason::kBadName, "session", "a robot, sensor or session has an invalid id");
    }
  }
  return absl::OkStatus();
}

absl::Status EntryLog::Append(const LogAppend& append) {
  if (absl::Status status = health(); !status.ok()) return status;
  if (absl::Status status = CheckSequence(append); !status.ok()) return status;
  if (append.entries.empty() && append.sessions.empty()) return absl::OkStatus();
  if (absl::Status status = BeginSegment(append.uptime); !status.ok()) return status;
  std::vector<std::string> headers(append.entries.size());
  std::vector<LogRecord> records;
  for (std::size_t i = 0; i < append.entries.size(); ++i) {
    const LogEntry& entry = append.entries[i];
    records.push_back(
        {RecordKindOf(entry.kind), entry.sequence.value(), PackEntry(entry, &headers[i])});
  }
  const std::string end = PackGroupEnd(append);
  records.push_back({LogRecordKind::kGroupEnd, group() + 1, {end}});
  absl::Status status = writer_->Append(records, map_);
  const absl::MutexLock lock(&mutex_);
  if (!status.ok()) {
    if (ReasonOf(status) != reason::kDiskLow) health_ = status;
    return status;
  }
  head_ = MapSequence(head_.value() + append.entries.size());
  ++group_;
  newest_uptime_ = std::max(newest_uptime_, append.uptime);
  segments_.back().bytes = writer_->size();
  return absl::OkStatus();
}

/// Creates a file to append to if there is none or the newest is full.
absl::Status EntryLog::BeginSegment(MapUptime uptime) {
  if (writer_ && writer_->size() < segment_bytes_) return absl::OkStatus();
  const SegmentStart start{map_, head().Next(), group() + 1, uptime};
  absl::StatusOr<LogSegmentWriter> writer = LogSegmentWriter::Create(PathOf(start), start);
  if (!writer.ok()) return writer.status();
  writer_ = *std::move(writer);
  const absl::MutexLock lock(&mutex_);
  segments_.push_back({start, writer_->size()});
  return absl::OkStatus();
}

absl::Status EntryLog::Read(MapSequence first,
                            MapSequence needed,
                            const std::function<absl::Status(LogEntry)>& visit) const {
  std::vector<Segment> segments;
  MapSequence head;
  {
    const absl::MutexLock lock(&mutex_);
    segments = segments_;
    head = head_;
  }
  if (first > head) return absl::OkStatus();
  MapSequence expected = std::max(first, needed);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (i + 1 < segments.size() && segments[i + 1].start.first_entry <= first) continue;
    absl::StatusOr<LogSegmentReader> reader =
        LogSegmentReader::Open(PathOf(segments[i].start), map_);
    if (!reader.ok()) return reader.status();
    while (true) {
      absl::StatusOr<std::optional<FoundRecord>> record =
          reader->Next([first](LogRecordKind kind, std::uint64_t number) {
            return kind != LogRecordKind::kGroupEnd && number >= first.value();
          });
      if (!record.ok()) return record.status();
      if (!record->has_value()) break;
      const MapSequence sequence((*record)->number);
      if ((*record)->kind == LogRecordKind::kGroupEnd || sequence < first) continue;
      if (sequence > expected) return MissingEntry(map_, expected);
      expected = sequence.Next();
      absl::StatusOr<LogEntry> entry = UnpackEntry(*std::move(*record));
      if (!entry.ok()) return entry.status();
      if (absl::Status status = visit(*std::move(entry)); !status.ok()) return status;
      // Another thread may be writing after the head.
      if (sequence == head) return absl::OkStatus();
    }
  }
  return expected <= head ? MissingEntry(map_, expected) : absl::OkStatus();
}

absl::Status EntryLog::Drop(const Done& done,
                            std::uint64_t kept_bytes,
                            MapUptime uptime,
                            std::chrono::seconds max_age) {
  std::vector<std::filesystem::path> dropped;
  {
    const absl::MutexLock lock(&mutex_);
    std::uint64_t total = 0;
    for (const Segment& segment : segments_) total += segment.bytes;
    while (!segments_.empty()) {
      const bool is_newest = segments_.size() == 1;
      const MapSequence last =
          is_newest ? head_ : MapSequence(segments_[1].start.first_entry.value() - 1);
      const std::uint64_t last_group = is_newest ? group_ : segments_[1].start.first_group - 1;
      const MapUptime youngest = is_newest ? newest_uptime_ : segments_[1].start.uptime;
      const bool wanted = total <= kept_bytes && uptime - youngest < max_age;
      if (wanted || last > done.entries || last_group > done.groups) break;
      dropped.push_back(PathOf(segments_.front().start));
      total -= segments_.front().bytes;
      segments_.erase(segments_.begin());
    }
    if (segments_.empty()) writer_.reset();
  }
  // Removed in order of age, so that a crash leaves no gap.
  for (const std::filesystem::path& path : dropped) {
    std::error_code error;
    std::filesystem::remove(path, error);
    if (error) return SystemError(error.value(), "remove", path);
  }
  return absl::OkStatus();
}

MapSequence EntryLog::head() const {
  const absl::MutexLock lock(&mutex_);
  return head_;
}

std::uint64_t EntryLog::group() const {
  const absl::MutexLock lock(&mutex_);
  return group_;
}

std::uint64_t EntryLog::bytes() const {
  std::uint64_t total = 0;
  const absl::MutexLock lock(&mutex_);
  for (const Segment& segment : segments_) total += segment.bytes;
  return total;
}

absl::Status EntryLog::health() const {
  const absl::MutexLock lock(&mutex_);
  return health_;
}

std::filesystem::path EntryLog::PathOf(const SegmentStart& start) const {
  return folder_ / absl::StrFormat("%020d%s", start.first_group, kExtension);
}

}  // namespace steadymap

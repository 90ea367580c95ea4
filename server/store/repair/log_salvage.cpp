#include "server/store/repair/log_salvage.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include "core/types/absl_text.h"
#include "server/store/disk/posix_file.h"
#include "server/store/log/log_segment.h"
#include "server/store/repair/store_check.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

/// The known properties of a file of the log.
struct LogFile {
  std::filesystem::path path;
  std::uint64_t first_group = 0;          ///< From the file name.
  std::optional<SegmentStart> start;      ///< Set if the header is readable.
  std::optional<MapSequence> last_entry;  ///< Set if the file is intact or its end is known.
  std::optional<std::uint64_t> last_group;
  bool is_whole = false;
  bool is_torn = false;  ///< Intact except for an unacknowledged write at its end.
};

absl::StatusOr<LogFile> Examine(const std::filesystem::path& path, MapKey map, bool is_newest) {
  LogFile file;
  file.path = path;
  const std::string stem = path.stem();
  std::from_chars(stem.data(), stem.data() + stem.size(), file.first_group);
  const absl::StatusOr<SegmentScan> scan = ScanSegment(path, map, is_newest);
  if (scan.ok()) {
    file.start = scan->start;
    file.last_entry = scan->last_entry;
    file.last_group = scan->last_group;
    file.is_torn = scan->end != scan->file_bytes;
    file.is_whole = !file.is_torn;
    return file;
  }
  const absl::StatusOr<LogSegmentReader> reader = LogSegmentReader::Open(path, map);
  if (reader.ok() && reader->start().first_group == file.first_group) file.start = reader->start();
  return file;
}

/// Rebuilds one damaged file, group by group. Fills gaps between the existing records with entries
/// without effect.
class SegmentRebuild {
 public:
  /// `last_entry` and `last_group` are the last ones of the file, where they are known.
  SegmentRebuild(LogSegmentWriter* writer,
                 const SegmentStart& start,
                 std::optional<MapSequence> last_entry,
                 std::optional<std::uint64_t> last_group,
                 std::optional<MapSequence> skip_entry,
                 SalvagedLog* log)
      : writer_(writer),
        map_(start.map),
        last_entry_(last_entry),
        last_group_(last_group),
        skip_entry_(skip_entry),
        log_(log),
        next_entry_(start.first_entry.value()),
        next_group_(start.first_group) {}

  absl::Status Take(const IntactRecord& found) {
    const FoundRecord& record = found.record;
    if (record.kind != LogRecordKind::kGroupEnd) {
      if (record.number < next_entry_ + pending_.size()) return absl::OkStatus();
      FillTo(record.number);
      const bool passes_over = skip_entry_ && record.number == skip_entry_->value();
      pending_.push_back(passes_over ? Nothing(record.number) : record);
      return absl::OkStatus();
    }
    if (record.number < next_group_) return absl::OkStatus();
    TakeSessions(record.payload);
    if (record.number == last_group_ && last_entry_) FillTo(last_entry_->value() + 1);
    while (next_group_ < record.number) {
      if (absl::Status status = Write({}, {}); !status.ok()) return status;
    }
    return WritePending(record.payload);
  }

  /// Writes the entries and groups that are known to follow the last record.
  absl::Status Finish() {
    if (!last_entry_ || !last_group_ || next_group_ > *last_group_) return absl::OkStatus();
    FillTo(last_entry_->value() + 1);
    while (next_group_ < *last_group_) {
      if (absl::Status status = Write({}, {}); !status.ok()) return status;
    }
    return WritePending({});
  }

  std::size_t pending() const { return pending_.size(); }

  MapSequence last_entry() const { return MapSequence(next_entry_ - 1); }

  std::uint64_t last_group() const { return next_group_ - 1; }

  const std::set<std::string>& robots() const { return robots_; }

 private:
  static FoundRecord Nothing(std::uint64_t number) { return {LogRecordKind::kSkipped, number, {}}; }

  void FillTo(std::uint64_t end) {
    for (std::uint64_t number = next_entry_ + pending_.size(); number < end; ++number) {
      log_->lost.emplace_back(number);
      pending_.push_back(Nothing(number));
    }
  }

  /// The sessions in a group's end contain the robots that sent its frames, and the last frame of
  /// each.
  void TakeSessions(const std::string& payload) {
    storage::v1::LogGroup group;
    if (!group.ParseFromString(payload)) return;
    for (const storage::v1::SessionRecord& session : group.sessions()) {
      robots_.insert(session.robot());
      FillTo(session.last_map_seq() + 1);
    }
  }

  absl::Status WritePending(const std::string& end) {
    std::vector<FoundRecord> entries;
    entries.swap(pending_);
    next_entry_ += entries.size();
    return Write(entries, end);
  }

  absl::Status Write(const std::vector<FoundRecord>& entries, const std::string& end) {
    std::vector<LogRecord> records;
    records.reserve(entries.size() + 1);
    for (const FoundRecord& entry : entries) {
      records.push_back({entry.kind, entry.number, {entry.payload}});
    }
    records.push_back({LogRecordKind::kGroupEnd, next_group_++, {end}});
    return writer_->Append(records, map_);
  }

  LogSegmentWriter* const writer_;
  const MapKey map_;
  const std::optional<MapSequence> last_entry_;
  const std::optional<std::uint64_t> last_group_;
  const std::optional<MapSequence> skip_entry_;
  SalvagedLog* const log_;
  std::uint64_t next_entry_;
  std::uint64_t next_group_;
  std::vector<FoundRecord> pending_;  ///< Entries of the group whose end was not reached yet.
  std::set<std::string> robots_;
};

/// Copies or rebuilds the files of a log, one by one.
class LogSalvage {
 public:
  LogSalvage(std::filesystem::path to, MapKey map, std::optional<MapSequence> skip_entry)
      : to_(std::move(to)), map_(map), skip_entry_(skip_entry) {}

  absl::Status Take(const LogFile& file, const LogFile* next) {
    std::vector<IntactRecord> records;
    const bool holds_skipped = skip_entry_ && file.start && file.last_entry &&
                               *skip_entry_ >= file.start->first_entry &&
                               *skip_entry_ <= *file.last_entry;
    if (!file.is_whole || holds_skipped) {
      absl::StatusOr<std::vector<IntactRecord>> found = FindIntactRecords(file.path, map_);
      if (!found.ok()) return found.status();
      records = *std::move(found);
    }
    const std::optional<MapSequence> first = FirstEntry(file, records);
    if (!first) {
      log_.remarks.push_back(
          absl::StrCat("log file ", file.path.string(), " contains no readable record"));
      return absl::OkStatus();
    }
    if (absl::Status status = Bridge(*first, file.first_group); !status.ok()) return status;
    skipped_ = skipped_ || holds_skipped;
    if (file.is_whole && !holds_skipped) {
      std::error_code error;
      std::filesystem::copy_file(file.path, to_ / file.path.filename(), error);
      if (error) return SystemError(error.value(), "copy", file.path);
      Advance(*first, file.first_group, *file.last_entry, *file.last_group);
      return absl::OkStatus();
    }
    return Rebuild(file, next, *first, records);
  }

  absl::StatusOr<SalvagedLog> Finish() {
    if (skip_entry_ && !skipped_) {
      return absl::NotFoundError(
          absl::StrCat("entry ", skip_entry_->value(), " is not in the map's log"));
    }
    return std::move(log_);
  }

 private:
  std::optional<MapSequence> FirstEntry(const LogFile& file,
                                        const std::vector<IntactRecord>& records) const {
    if (file.start) return file.start->first_entry;
    if (log_.last_group != 0 && log_.last_group + 1 == file.first_group) return log_.head.Next();
    for (const IntactRecord& found : records) {
      if (found.record.kind != LogRecordKind::kGroupEnd) return MapSequence(found.record.number);
    }
    return std::nullopt;
  }

  /// Writes a file without effect in place of missing files before this one.
  absl::Status Bridge(MapSequence first, std::uint64_t first_group) {
    if (log_.last_group == 0 || log_.last_group + 1 >= first_group) return absl::OkStatus();
    const SegmentStart start{map_, log_.head.Next(), log_.last_group + 1, MapUptime(0)};
    log_.remarks.push_back(absl::StrCat("the log files with the groups ",
                                        start.first_group,
                                        " to ",
                                        first_group - 1,
                                        " are missing"));
    return Write(start, {}, MapSequence(first.value() - 1), first_group - 1);
  }

  absl::Status Rebuild(const LogFile& file,
                       const LogFile* next,
                       MapSequence first,
                       const std::vector<IntactRecord>& records) {
    const SegmentStart start =
        file.start.value_or(SegmentStart{map_, first, file.first_group, MapUptime(0)});
    const std::size_t lost = log_.lost.size();
    std::optional<MapSequence> last_entry = file.last_entry;
    std::optional<std::uint64_t> last_group = file.last_group;
    if (next != nullptr && next->start) {
      last_entry = MapSequence(next->start->first_entry.value() - 1);
      last_group = next->first_group - 1;
    }
    if (absl::Status status = Write(start, records, last_entry, last_group); !status.ok()) {
      return status;
    }
    if (log_.lost.size() == lost && (file.is_whole || file.is_torn)) return absl::OkStatus();
    log_.remarks.push_back(absl::StrCat("log file ",
                                        file.path.string(),
                                        " was damaged; ",
                                        log_.lost.size() - lost,
                                        " of its entries are lost; the file contains "
                                        "frames of the robots: ",
                                        absl::StrJoin(robots_, ", ")));
    return absl::OkStatus();
  }

  absl::Status Write(const SegmentStart& start,
                     const std::vector<IntactRecord>& records,
                     std::optional<MapSequence> last_entry,
                     std::optional<std::uint64_t> last_group) {
    absl::StatusOr<LogSegmentWriter> writer =
        LogSegmentWriter::Create(to_ / absl::StrFormat("%020d.log", start.first_group), start);
    if (!writer.ok()) return writer.status();
    SegmentRebuild rebuild(&*writer, start, last_entry, last_group, skip_entry_, &log_);
    for (const IntactRecord& record : records) {
      const bool is_beyond = record.record.kind == LogRecordKind::kGroupEnd
                                 ? last_group && record.record.number > *last_group
                                 : last_entry && record.record.number > last_entry->value();
      if (is_beyond) continue;
      if (absl::Status status = rebuild.Take(record); !status.ok()) return status;
    }
    if (absl::Status status = rebuild.Finish(); !status.ok()) return status;
    if (rebuild.pending() > 0) {
      log_.remarks.push_back(absl::StrCat("the last ",
                                          rebuild.pending(),
                                          " entries of the log belong to an incomplete group: they "
                                          "may never have been acknowledged, and are dropped"));
    }
    robots_ = rebuild.robots();
    Advance(start.first_entry, start.first_group, rebuild.last_entry(), rebuild.last_group());
    return absl::OkStatus();
  }

  void Advance(MapSequence first_entry,
               std::uint64_t first_group,
               MapSequence last_entry,
               std::uint64_t last_group) {
    if (log_.first_group == 0) {
      log_.first_group = first_group;
      log_.first_entry = first_entry;
    }
    log_.head = last_entry;
    log_.last_group = last_group;
  }

  const std::filesystem::path to_;
  const MapKey map_;
  const std::optional<MapSequence> skip_entry_;
  SalvagedLog log_;
  std::set<std::string> robots_;  ///< Robots of the last rebuilt file.
  bool skipped_ = false;
};

}  // namespace

absl::StatusOr<SalvagedLog> SalvageLog(const std::filesystem::path& from,
                                       const std::filesystem::path& to,
                                       MapKey map,
                                       std::optional<MapSequence> skip_entry) {
  if (absl::Status status = MakeFolder(to); !status.ok()) return status;
  const std::vector<std::filesystem::path> paths = LogFiles(from);
  std::vector<LogFile> files;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    absl::StatusOr<LogFile> file = Examine(paths[i], map, i + 1 == paths.size());
    if (!file.ok()) return file.status();
    files.push_back(*std::move(file));
  }
  LogSalvage salvage(to, map, skip_entry);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const LogFile* const next = i + 1 < files.size() ? &files[i + 1] : nullptr;
    if (absl::Status status = salvage.Take(files[i], next); !status.ok()) return status;
  }
  return salvage.Finish();
}

}  // namespace steadymap

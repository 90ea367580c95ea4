// The log side of RocksStore: frames, poses and sessions going in, frames and poses coming out.

#include <algorithm>
#include <array>
#include <utility>

#include <absl/strings/str_cat.h>
#include <rocksdb/snapshot.h>

#include "core/error.h"
#include "server/rocks_store.h"
#include "server/store_keys.h"
#include "server/store_records.h"

namespace steadymap {
namespace {

absl::Status MissingFrame(MapKey map, MapSequence sequence) {
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("the log of map ", map.value(), " lacks frame ", sequence.value()));
}

absl::StatusOr<FramePose> ReadPose(const rocksdb::Iterator& scan) {
  const ValuePlace place{NameOf(Family::kPose), scan.key().ToStringView()};
  const std::optional<MapSequence> sequence = SequenceOfFrameKey(place.key);
  if (!sequence) return DamagedValue(place, "is filed under no frame");
  storage::v1::PoseRecord record;
  if (absl::Status status = UnsealRecord(place, scan.value().ToStringView(), &record);
      !status.ok()) {
    return status;
  }
  return PoseFromProto(*sequence, record);
}

// A frame of the log is its bytes in `log` and its pose in `pose`.
absl::StatusOr<LogFrame> ReadFrame(const rocksdb::Iterator& log, rocksdb::Iterator* poses) {
  const ValuePlace place{NameOf(Family::kLog), log.key().ToStringView()};
  const absl::StatusOr<std::string_view> packed = Unseal(place, log.value().ToStringView());
  if (!packed.ok()) return packed.status();
  while (poses->Valid() && poses->key().compare(log.key()) < 0) poses->Next();
  if (!poses->status().ok()) return FromRocksdb(poses->status(), "reading poses");
  if (!poses->Valid() || poses->key() != log.key()) return DamagedValue(place, "has no pose");
  absl::StatusOr<FramePose> pose = ReadPose(*poses);
  if (!pose.ok()) return pose.status();
  return LogFrame{pose->sequence,
                  std::move(pose->robot),
                  pose->capture_time,
                  pose->T_world_camera,
                  std::string(*packed)};
}

}  // namespace

absl::Status RocksStore::AppendFrames(const std::vector<LogAppend>& appends) {
  if (absl::Status status = database_->health(); !status.ok()) return status;
  if (absl::Status status = CheckDisk(); !status.ok()) return status;
  std::vector<MapKey> maps;
  for (const LogAppend& append : appends) maps.push_back(append.map);
  std::sort(maps.begin(), maps.end());
  if (std::adjacent_find(maps.begin(), maps.end()) != maps.end()) {
    return absl::FailedPreconditionError("a map may appear once in an append");
  }
  const WriteTurns::Turn turn(&append_turns_, maps);
  rocksdb::WriteBatch batch;
  std::vector<std::pair<MapKey, storage::v1::LogHead>> heads;
  for (const LogAppend& append : appends) {
    const absl::StatusOr<MapEntry> entry = Find(append.map);
    if (!entry.ok()) return entry.status();
    storage::v1::LogHead head = entry->log_head;
    if (absl::Status status = PutAppend(append, &head, &batch); !status.ok()) return status;
    heads.emplace_back(append.map, std::move(head));
  }
  if (batch.Count() == 0) return absl::OkStatus();
  if (absl::Status status = database_->Write(&batch); !status.ok()) return status;
  const absl::MutexLock lock(&mutex_);
  for (auto& [map, head] : heads) entries_.at(map).log_head = std::move(head);
  return absl::OkStatus();
}

absl::Status RocksStore::PutAppend(const LogAppend& append,
                                   storage::v1::LogHead* head,
                                   rocksdb::WriteBatch* batch) const {
  head->set_append_time_ns(std::max(head->append_time_ns(), append.append_time.nanoseconds()));
  for (const LogFrame& frame : append.frames) {
    if (frame.sequence.value() != head->durable_map_seq() + 1) {
      return absl::FailedPreconditionError(absl::StrCat("frame ",
                                                        frame.sequence.value(),
                                                        " does not follow frame ",
                                                        head->durable_map_seq(),
                                                        " of map ",
                                                        append.map.value()));
    }
    const std::string key = FrameKey(append.map, frame.sequence);
    // Gathered, so that the largest thing there is is copied once only.
    const std::string header = SealHeader({NameOf(Family::kLog), key}, frame.packed_frame);
    const rocksdb::Slice key_part(key);
    const std::array<rocksdb::Slice, 2> value_parts = {header, frame.packed_frame};
    batch->Put(database_->handle(Family::kLog), {&key_part, 1}, {value_parts.data(), 2});
    storage::v1::PoseRecord pose;
    PoseToProto(frame, &pose);
    pose.set_append_time_ns(head->append_time_ns());
    pose.set_bytes_before(head->total_bytes());
    batch->Put(
        database_->handle(Family::kPose), key, SealRecord({NameOf(Family::kPose), key}, pose));
    head->set_durable_map_seq(frame.sequence.value());
    head->set_total_bytes(head->total_bytes() + frame.packed_frame.size());
  }
  for (const SessionRecord& session : append.sessions) {
    if (!IsValidId(session.name.robot) || !IsValidId(session.name.session)) {
      return InvalidField(reason::kBadName, "session", "a robot or session has no valid id");
    }
    const std::string key = SessionKey(append.map, session.name);
    batch->Put(database_->handle(Family::kDedup),
               key,
               SealRecord({NameOf(Family::kDedup), key}, ToProto(session)));
  }
  if (append.frames.empty()) return absl::OkStatus();
  const std::string key = LogHeadKey(append.map);
  batch->Put(
      database_->handle(Family::kMeta), key, SealRecord({NameOf(Family::kMeta), key}, *head));
  return absl::OkStatus();
}

absl::Status RocksStore::ReadLog(MapKey map,
                                 MapSequence first,
                                 const std::function<absl::Status(LogFrame)>& visit) {
  if (absl::Status status = Find(map).status(); !status.ok()) return status;
  rocksdb::ManagedSnapshot snapshot(&database_->database());
  const absl::StatusOr<MapEntry> entry = LoadEntry(map, snapshot.snapshot());
  if (!entry.ok()) return entry.status();
  const MapSequence head{entry->log_head.durable_map_seq()};
  const std::string end = MapRange(map).end;
  const rocksdb::Slice upper_bound(end);
  const std::unique_ptr<rocksdb::Iterator> log =
      database_->Scan(Family::kLog, &upper_bound, snapshot.snapshot());
  const std::unique_ptr<rocksdb::Iterator> poses =
      database_->Scan(Family::kPose, &upper_bound, snapshot.snapshot());
  // Up to here retention may have dropped frames; behind it none may be missing.
  MapSequence expected{std::max(first.value(), entry->revision_head.revision() + 1)};
  poses->Seek(FrameKey(map, first));
  for (log->Seek(FrameKey(map, first)); log->Valid(); log->Next()) {
    absl::StatusOr<LogFrame> frame = ReadFrame(*log, poses.get());
    if (!frame.ok()) return frame.status();
    if (frame->sequence > expected) return MissingFrame(map, expected);
    expected = frame->sequence.Next();
    if (absl::Status status = visit(*std::move(frame)); !status.ok()) return status;
  }
  if (!log->status().ok()) {
    return FromRocksdb(log->status(), absl::StrCat("reading the log of map ", map.value()));
  }
  return expected <= head ? MissingFrame(map, expected) : absl::OkStatus();
}

absl::StatusOr<std::vector<FramePose>> RocksStore::ReadPoses(MapKey map,
                                                             MapSequence first,
                                                             MapSequence last,
                                                             std::size_t limit) {
  const absl::StatusOr<MapEntry> entry = Find(map);
  if (!entry.ok()) return entry.status();
  std::vector<FramePose> poses;
  const std::string end = MapRange(map).end;
  const rocksdb::Slice upper_bound(end);
  const std::unique_ptr<rocksdb::Iterator> scan = database_->Scan(Family::kPose, &upper_bound);
  for (scan->Seek(FrameKey(map, first)); scan->Valid() && poses.size() < limit; scan->Next()) {
    absl::StatusOr<FramePose> pose = ReadPose(*scan);
    if (!pose.ok()) return pose.status();
    if (pose->sequence > last) break;
    poses.push_back(*std::move(pose));
  }
  if (!scan->status().ok()) {
    return FromRocksdb(scan->status(), absl::StrCat("reading the poses of map ", map.value()));
  }
  return poses;
}

}  // namespace steadymap

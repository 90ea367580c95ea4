#include "server/store/map/state_reading.h"

#include <memory>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "server/store/database/store_keys.h"

namespace steadymap {

absl::Status ForEachRecord(
    const StateDatabase& state,
    Family family,
    const rocksdb::Snapshot* snapshot,
    const std::function<absl::Status(const ValuePlace&, std::string_view)>& visit) {
  const KeyRange range = RangeOf(family);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan = state.Scan(family, &upper_bound, snapshot);
  for (scan->Seek(range.begin); scan->Valid(); scan->Next()) {
    const ValuePlace place{NameOf(family), scan->key().ToStringView()};
    if (absl::Status status = visit(place, scan->value().ToStringView()); !status.ok()) {
      return status;
    }
  }
  return FromRocksdb(scan->status(), absl::StrCat("reading ", NameOf(family).data()));
}

absl::Status ReadHead(const StateDatabase& state,
                      const rocksdb::Snapshot* snapshot,
                      storage::v1::Head* head) {
  const std::string key = HeadKey();
  const absl::StatusOr<std::string> value = state.Read(Family::kMeta, key, snapshot);
  const ValuePlace place{NameOf(Family::kMeta), key};
  if (absl::IsNotFound(value.status())) return DamagedValue(place, "is missing");
  if (!value.ok()) return value.status();
  return UnsealRecord(place, *value, head);
}

absl::Status ReadAddedClasses(const StateDatabase& state,
                              const rocksdb::Snapshot* snapshot,
                              std::vector<SemanticClass>* classes) {
  const absl::StatusOr<std::string> value = state.Read(Family::kMeta, ClassTableKey(), snapshot);
  if (absl::IsNotFound(value.status())) return absl::OkStatus();
  if (!value.ok()) return value.status();
  storage::v1::ClassTable table;
  if (absl::Status status = UnsealRecord({NameOf(Family::kMeta), ClassTableKey()}, *value, &table);
      !status.ok()) {
    return status;
  }
  for (const storage::v1::SemanticClass& row : table.classes()) {
    absl::StatusOr<SemanticClass> read = FromProto(row);
    if (!read.ok()) return read.status();
    classes->push_back(*std::move(read));
  }
  return absl::OkStatus();
}

absl::Status ReadSessions(const StateDatabase& state,
                          const rocksdb::Snapshot* snapshot,
                          std::vector<SessionRecord>* sessions) {
  return ForEachRecord(state,
                       Family::kSession,
                       snapshot,
                       [sessions](const ValuePlace& place, std::string_view value) {
                         storage::v1::SessionRecord proto;
                         if (absl::Status status = UnsealRecord(place, value, &proto); !status.ok())
                           return status;
                         absl::StatusOr<SessionRecord> session = FromProto(proto);
                         if (!session.ok()) return session.status();
                         sessions->push_back(*std::move(session));
                         return absl::OkStatus();
                       });
}

}  // namespace steadymap

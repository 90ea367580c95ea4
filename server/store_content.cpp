// How RocksStore reads the committed state of a map.

#include <array>
#include <map>
#include <memory>
#include <utility>

#include <absl/strings/str_cat.h>
#include <rocksdb/snapshot.h>

#include "core/error.h"
#include "core/tsdf_codec.h"
#include "server/object_records.h"
#include "server/robot_records.h"
#include "server/rocks_store.h"
#include "server/store_keys.h"
#include "server/store_records.h"

namespace steadymap {
namespace {

// Names the map in an error that so far names a key only.
absl::Status OfMap(const MapRecord& record, const absl::Status& status) {
  return MakeError(
      status.code(),
      ReasonOf(status),
      absl::StrCat("map ", record.name.ToString(), ": ", std::string(status.message())));
}

absl::StatusOr<SessionRecord> LoadSession(const ValuePlace& place, std::string_view value) {
  storage::v1::SessionRecord proto;
  if (absl::Status status = UnsealRecord(place, value, &proto); !status.ok()) return status;
  return FromProto(proto);
}

/// Puts records into a snapshot: objects first, then their leaves.
class ContentLoader {
 public:
  explicit ContentLoader(MapSnapshot* content) : content_(content) {}

  absl::Status LoadObject(const ValuePlace& place, std::string_view value) {
    const std::optional<ObjectId> id = ObjectOfKey(place.key);
    if (!id) return DamagedValue(place, "is filed under no object");
    storage::v1::ObjectRecord record;
    if (absl::Status status = UnsealRecord(place, value, &record); !status.ok()) return status;
    absl::StatusOr<ObjectState> state = FromProto(*id, record.state());
    if (!state.ok()) return DamagedValue(place, std::string(state.status().message()));
    objects_[*id] = {*std::move(state), std::make_shared<TsdfGrid>()};
    return absl::OkStatus();
  }

  absl::Status LoadLeaf(const ValuePlace& place, std::string_view value) {
    const std::optional<LeafKey> key = LeafOfStoreKey(place.key);
    if (!key) return DamagedValue(place, "is filed under no leaf");
    storage::v1::LeafRecord record;
    if (absl::Status status = UnsealRecord(place, value, &record); !status.ok()) return status;
    LeafVoxels voxels;
    if (absl::Status status = UnpackLeaf(record.packed(), content_->scale, &voxels); !status.ok()) {
      return DamagedValue(place, std::string("is no leaf: ") + std::string(status.message()));
    }
    if (key->object == kBackgroundId) {
      content_->background.MutableTile(key->origin).StoreLeaf(key->origin, voxels);
      return absl::OkStatus();
    }
    const auto owner = objects_.find(key->object);
    if (owner == objects_.end()) return DamagedValue(place, "is a leaf of an object not there");
    owner->second.volume->StoreLeaf(key->origin, voxels);
    return absl::OkStatus();
  }

  absl::Status LoadFreeBlock(const ValuePlace& place, std::string_view value) {
    const std::optional<LeafOrigin> origin = FreeBlockOfKey(place.key);
    if (!origin) return DamagedValue(place, "is filed under no block of free space");
    storage::v1::FreeBlockRecord record;
    if (absl::Status status = UnsealRecord(place, value, &record); !status.ok()) return status;
    const absl::StatusOr<LeafMask> cells = FromProto(record);
    if (!cells.ok()) return DamagedValue(place, std::string(cells.status().message()));
    content_->free_space.StoreBlock(*origin, *cells);
    return absl::OkStatus();
  }

  absl::Status LoadRobot(const ValuePlace& place, std::string_view value) {
    const std::optional<std::string> robot = RobotOfKey(place.key);
    if (!robot) return DamagedValue(place, "is filed under no robot");
    storage::v1::RobotRecord record;
    if (absl::Status status = UnsealRecord(place, value, &record); !status.ok()) return status;
    const absl::StatusOr<RobotState> state = FromProto(record);
    if (!state.ok()) return DamagedValue(place, std::string(state.status().message()));
    content_->robots[*robot] = *state;
    return absl::OkStatus();
  }

  void Finish() {
    for (auto& [id, object] : objects_) {
      content_->objects.insert_or_assign(
          id, std::make_shared<const MapObject>(MapObject{std::move(object.state), object.volume}));
    }
  }

 private:
  struct LoadedObject {
    ObjectState state;
    std::shared_ptr<TsdfGrid> volume;
  };

  MapSnapshot* content_;
  std::map<ObjectId, LoadedObject> objects_;
};

}  // namespace

absl::StatusOr<StoredState> RocksStore::LoadMap(const MapRecord& record) {
  if (absl::Status status = Find(record.key).status(); !status.ok()) return status;
  rocksdb::ManagedSnapshot snapshot(&database_->database());
  const absl::StatusOr<MapEntry> entry = LoadEntry(record.key, snapshot.snapshot());
  if (!entry.ok()) return OfMap(record, entry.status());
  StoredState state;
  state.durable_head = MapSequence{entry->log_head.durable_map_seq()};
  const MapConfig& config = entry->record.config;
  state.snapshot = MapSnapshot({config.voxel_size_m, config.truncation_m});
  state.snapshot.revision = Revision{entry->revision_head.revision()};
  state.snapshot.last_capture_time =
      Timestamp::FromNanoseconds(entry->revision_head.last_capture_time_ns());
  if (absl::Status status = LoadSessions(record.key, snapshot.snapshot(), &state); !status.ok()) {
    return OfMap(record, status);
  }
  state.snapshot.newest_object = ObjectId{entry->revision_head.newest_object()};
  state.snapshot.last_event = EventNumber{entry->revision_head.events()};
  if (absl::Status status = LoadContent(record.key, snapshot.snapshot(), &state.snapshot);
      !status.ok()) {
    return OfMap(record, status);
  }
  return state;
}

absl::Status RocksStore::ForEachRecord(Family family,
                                       MapKey map,
                                       const rocksdb::Snapshot* snapshot,
                                       const RecordVisitor& visit) const {
  const KeyRange range = MapRange(map);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan = database_->Scan(family, &upper_bound, snapshot);
  for (scan->Seek(range.begin); scan->Valid(); scan->Next()) {
    const ValuePlace place{NameOf(family), scan->key().ToStringView()};
    if (absl::Status status = visit(place, scan->value().ToStringView()); !status.ok()) {
      return status;
    }
  }
  return FromRocksdb(scan->status(), absl::StrCat("reading ", NameOf(family).data()));
}

absl::Status RocksStore::LoadSessions(MapKey map,
                                      const rocksdb::Snapshot* snapshot,
                                      StoredState* state) const {
  return ForEachRecord(
      Family::kDedup, map, snapshot, [state](const ValuePlace& place, std::string_view value) {
        absl::StatusOr<SessionRecord> session = LoadSession(place, value);
        if (!session.ok()) return session.status();
        state->sessions.push_back(*std::move(session));
        return absl::OkStatus();
      });
}

absl::Status RocksStore::LoadContent(MapKey map,
                                     const rocksdb::Snapshot* snapshot,
                                     MapSnapshot* content) const {
  ContentLoader loader(content);
  using Load = absl::Status (ContentLoader::*)(const ValuePlace&, std::string_view);
  static constexpr std::array<std::pair<Family, Load>, 4> kLoads = {
      {{Family::kObject, &ContentLoader::LoadObject},
       {Family::kLeaf, &ContentLoader::LoadLeaf},
       {Family::kFree, &ContentLoader::LoadFreeBlock},
       {Family::kRobot, &ContentLoader::LoadRobot}}};
  for (const auto& [family, load] : kLoads) {
    const auto visit = [&loader, load = load](const ValuePlace& place, std::string_view value) {
      return (loader.*load)(place, value);
    };
    if (absl::Status status = ForEachRecord(family, map, snapshot, visit); !status.ok()) {
      return status;
    }
  }
  loader.Finish();
  return absl::OkStatus();
}

absl::StatusOr<std::vector<StoredEvent>> RocksStore::ReadEvents(MapKey map,
                                                                EventNumber first,
                                                                std::size_t limit) {
  if (absl::Status status = Find(map).status(); !status.ok()) return status;
  std::vector<StoredEvent> events;
  const std::string end = MapRange(map).end;
  const rocksdb::Slice upper_bound(end);
  const std::unique_ptr<rocksdb::Iterator> scan = database_->Scan(Family::kEvent, &upper_bound);
  for (scan->Seek(EventKey(map, first)); scan->Valid() && events.size() < limit; scan->Next()) {
    const ValuePlace place{NameOf(Family::kEvent), scan->key().ToStringView()};
    const std::optional<EventNumber> number = EventOfKey(place.key);
    if (!number) return DamagedValue(place, "is filed under no event");
    storage::v1::EventRecord record;
    if (absl::Status status = UnsealRecord(place, scan->value().ToStringView(), &record);
        !status.ok()) {
      return status;
    }
    absl::StatusOr<ObjectEvent> event = FromProto(record);
    if (!event.ok()) return event.status();
    events.push_back({*number, *std::move(event)});
  }
  if (!scan->status().ok()) {
    return FromRocksdb(scan->status(), absl::StrCat("reading the events of map ", map.value()));
  }
  return events;
}

}  // namespace steadymap

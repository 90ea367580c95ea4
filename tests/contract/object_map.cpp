#include "tests/contract/object_map.h"

#include <gtest/gtest.h>

#include "core/map/map_delta.h"
#include "tests/support/analytic_map.h"

namespace steadymap {
namespace {

using ::steadymap::testing::AddObject;
using ::steadymap::testing::BoxObject;
using ::steadymap::testing::FloorMap;

const Eigen::Vector3d kSizeM(0.4, 0.3, 0.3);

/// Returns box `id` above the floor at x = id - 1.5 m, of class 100 + id, changed by frame `id`.
MapObject MakeBox(std::uint64_t id, ObjectStatus standing, double alpha) {
  MapObject object =
      BoxObject(ObjectId(id), kSizeM, {{-1.5 + static_cast<double>(id), 0.5, 0.8}, 0.3});
  object.status = standing;
  object.revision = Revision(id);
  object.belief.alpha = alpha;
  object.votes = {{ClassId(4), 1.0}, {object.class_id, 3.0}};
  object.first_seen = Timestamp::FromSeconds(100.0);
  object.last_seen = Timestamp::FromSeconds(200.0);
  object.supporting_frames = 5;
  return object;
}

}  // namespace

MapSnapshot MakeObjectMap() {
  MapSnapshot map = FloorMap();
  map.revision = Revision(kObjectMapRevision);
  map.last_capture_time = Timestamp::FromSeconds(200.0);
  AddObject(MakeBox(1, ObjectStatus::kPresent, 9.0), &map);
  AddObject(MakeBox(2, ObjectStatus::kArchived, 0.5), &map);
  AddObject(MakeBox(3, ObjectStatus::kPresent, 3.0), &map);
  AddObject(MakeBox(4, ObjectStatus::kTentative, 2.0), &map);
  map.newest_object = ObjectId(4);
  return map;
}

std::vector<ObjectEvent> MakeObjectHistory(const MapSnapshot& map) {
  std::vector<ObjectEvent> events;
  const auto add = [&](EventType type, EventReason why, std::uint64_t id, std::uint64_t revision) {
    ObjectEvent& event = events.emplace_back();
    event.type = type;
    event.reason = why;
    event.object = ObjectId(id);
    event.class_id = map.objects.at(event.object)->class_id;
    event.time = Timestamp::FromSeconds(100.0 + 10.0 * static_cast<double>(revision));
    event.revision = Revision(revision);
    event.center_world = map.objects.at(event.object)->cuboid.center_world;
    event.supporting_frames = 10 * id;
    event.contradicted_updates = revision;
  };
  add(EventType::kCreated, EventReason::kNewSurface, 1, 2);
  add(EventType::kCreated, EventReason::kNewSurface, 2, 2);
  add(EventType::kCreated, EventReason::kNewSurface, 3, 4);
  add(EventType::kMoved, EventReason::kShapeMatched, 1, 5);
  events.back().old_center_world = Eigen::Vector3d(1.0, 1.0, 1.0);
  events.back().confidence = 0.75;
  add(EventType::kRemoved, EventReason::kSeenThrough, 2, 6);
  events.back().related = ObjectId(3);
  return events;
}

MapSnapshot MakeCrowdedMap(int boxes) {
  MapSnapshot map = FloorMap();
  map.revision = Revision(kObjectMapRevision);
  map.last_capture_time = Timestamp::FromSeconds(200.0);
  for (int i = 1; i <= boxes; ++i) {
    AddObject(MakeBox(static_cast<std::uint64_t>(i), ObjectStatus::kPresent, 9.0), &map);
  }
  map.newest_object = ObjectId(static_cast<std::uint64_t>(boxes));
  return map;
}

void StoreObjectMap(TestService* service) {
  const MapSnapshot map = MakeObjectMap();
  StoreMap(service, map, MakeObjectHistory(map));
}

void StoreMap(TestService* service,
              const MapSnapshot& map,
              const std::vector<ObjectEvent>& events) {
  MapDelta delta = Diff(MapSnapshot(map.scale), map);
  delta.events = events;
  const MapKey key = service->store().ListMaps()->front().key;
  LogAppend append{key, MapUptime(1), {}, {}};
  for (std::uint64_t sequence = 1; sequence <= kObjectMapRevision; ++sequence) {
    append.entries.emplace_back().sequence = MapSequence(sequence);
  }
  EXPECT_TRUE(service->store().Append(append).ok());
  const absl::StatusOr<CommitMark> committed =
      service->store().CommitRevision(key, delta, {.uptime = MapUptime(1)});
  EXPECT_TRUE(committed.ok()) << committed.status();
  service->Restart();
}

}  // namespace steadymap

#include "client/bench/evaluation/room/room_score.h"

#include <algorithm>
#include <cmath>

#include <absl/strings/str_format.h>

#include "client/bench/evaluation/truth/place_text.h"
#include "core/types/absl_text.h"

namespace steadymap {
namespace {

// A thing is announced when a part of it has been seen; of furniture, only a part may be.
constexpr double kCreationMarginM = 0.1;
constexpr double kFurnitureMarginM = 0.5;

// Of a piece of the wall.
constexpr double kWallMarginM = 0.15;

std::string EventText(std::string_view fault,
                      EventType type,
                      ClassId class_id,
                      const Eigen::Vector3d& center_world) {
  return absl::StrFormat("%s %s of class %d at %s",
                         Absl(fault),
                         Absl(NameOf(type)),
                         class_id.value(),
                         PlaceText(center_world));
}

bool IsNear(const Eigen::Vector3d& center_world,
            const Eigen::AlignedBox3d& box_world,
            double margin_m) {
  return box_world.exteriorDistance(center_world) <= margin_m;
}

bool Matches(const RoomEvent& expected, const ObjectEvent& event, const RoomTolerance& tolerance) {
  if (event.type != expected.type) return false;
  if (tolerance.compares_classes && event.class_id != expected.class_id) return false;
  if (expected.is_furniture) {
    return IsNear(event.center_world, expected.box_world, kFurnitureMarginM);
  }
  if (expected.type == EventType::kCreated) {
    return IsNear(event.center_world, expected.box_world, kCreationMarginM);
  }
  return (event.center_world - expected.box_world.center()).norm() <= tolerance.place_m;
}

bool IsOfWall(const BoxRoom& room,
              ClassId class_id,
              const Eigen::Vector3d& center_world,
              const RoomTolerance& tolerance) {
  if (tolerance.compares_classes) return class_id == room.wall_class;
  return IsNear(center_world, room.wall_world, kWallMarginM);
}

void ScoreEvents(const BoxRoom& room,
                 const std::vector<ObjectEvent>& events,
                 const RoomTolerance& tolerance,
                 std::vector<std::string>* faults) {
  std::vector<bool> used(events.size(), false);
  for (const RoomEvent& truth : room.events) {
    bool is_found = false;
    for (std::size_t i = 0; i < events.size() && !is_found; ++i) {
      if (used[i] || !Matches(truth, events[i], tolerance)) continue;
      used[i] = true;
      is_found = true;
    }
    if (is_found || !truth.is_required) continue;
    faults->push_back(EventText("missing", truth.type, truth.class_id, truth.box_world.center()));
  }
  for (std::size_t i = 0; i < events.size(); ++i) {
    const ObjectEvent& event = events[i];
    if (used[i] || event.type == EventType::kUpdated) continue;
    if (IsOfWall(room, event.class_id, event.center_world, tolerance)) continue;
    faults->push_back(EventText("extra", event.type, event.class_id, event.center_world));
  }
}

Eigen::AlignedBox3d AlignedBoxOf(const Cuboid& cuboid) {
  Eigen::AlignedBox3d box_world;
  for (const Eigen::Vector2d& corner : cuboid.BaseCorners()) {
    box_world.extend(Eigen::Vector3d(corner.x(), corner.y(), cuboid.lowest_m()));
    box_world.extend(Eigen::Vector3d(corner.x(), corner.y(), cuboid.highest_m()));
  }
  return box_world;
}

bool Matches(const RoomObject& expected, const MapObject& object, const RoomTolerance& tolerance) {
  if (tolerance.compares_classes && object.class_id != expected.class_id) return false;
  const Eigen::Vector3d& center_world = object.cuboid.center_world;
  if (expected.is_furniture) return IsNear(center_world, expected.box_world, kFurnitureMarginM);
  return (center_world - expected.box_world.center()).norm() <= tolerance.place_m;
}

void ScoreObjects(const BoxRoom& room,
                  const MapSnapshot& map,
                  const RoomTolerance& tolerance,
                  RoomScore* score) {
  std::vector<const MapObject*> present;
  for (const auto& [id, object] : map.objects) {
    if (object->status == ObjectStatus::kPresent) present.push_back(object.get());
  }
  for (const RoomObject& truth : room.objects) {
    const auto found = std::find_if(present.begin(), present.end(), [&](const MapObject* object) {
      return Matches(truth, *object, tolerance);
    });
    if (found == present.end()) {
      if (!truth.is_required) continue;
      score->object_faults.push_back(absl::StrFormat("missing object of class %d at %s",
                                                     truth.class_id.value(),
                                                     PlaceText(truth.box_world.center())));
      continue;
    }
    if (!truth.is_furniture) {
      const double error_m = CuboidErrorM((*found)->cuboid, truth.box_world);
      score->worst_cuboid_m = std::max(score->worst_cuboid_m, error_m);
      if (error_m > tolerance.cuboid_m) {
        const Eigen::AlignedBox3d box_world = AlignedBoxOf((*found)->cuboid);
        score->cuboid_faults.push_back(
            absl::StrFormat("cuboid of class %d: lowest corner off by %s m, highest by %s m",
                            truth.class_id.value(),
                            PlaceText(box_world.min() - truth.box_world.min()),
                            PlaceText(box_world.max() - truth.box_world.max())));
      }
    }
    present.erase(found);
  }
  for (const MapObject* object : present) {
    if (IsOfWall(room, object->class_id, object->cuboid.center_world, tolerance)) continue;
    score->object_faults.push_back(absl::StrFormat("extra object of class %d at %s",
                                                   object->class_id.value(),
                                                   PlaceText(object->cuboid.center_world)));
  }
}

}  // namespace

double CuboidErrorM(const Cuboid& cuboid, const Eigen::AlignedBox3d& truth_world) {
  const Eigen::AlignedBox3d box_world = AlignedBoxOf(cuboid);
  return std::max((box_world.min() - truth_world.min()).cwiseAbs().maxCoeff(),
                  (box_world.max() - truth_world.max()).cwiseAbs().maxCoeff());
}

RoomScore ScoreRoom(const BoxRoom& room,
                    const std::vector<ObjectEvent>& events,
                    const MapSnapshot& map,
                    const RoomTolerance& tolerance) {
  RoomScore score;
  ScoreEvents(room, events, tolerance, &score.event_faults);
  ScoreObjects(room, map, tolerance, &score);
  return score;
}

}  // namespace steadymap

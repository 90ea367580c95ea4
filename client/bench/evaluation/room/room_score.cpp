#include "client/bench/evaluation/room/room_score.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <absl/strings/str_format.h>

#include "client/bench/evaluation/truth/place_text.h"
#include "core/geometry/assignment.h"
#include "core/types/absl_text.h"

namespace steadymap {
namespace {

// A thing is announced when a part of it has been seen; of furniture, only a part may be.
constexpr double kCreationMarginM = 0.1;
constexpr double kFurnitureMarginM = 0.5;

// Of a piece of the wall.
constexpr double kWallMarginM = 0.15;

// Costs of a matching, metres: as many of the truth as possible are matched, and what is required
// before what is optional; among equals, centres that are near each other.
constexpr double kUnmatchedM = 1e6;
constexpr double kOptionalM = 1e3;

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

const Eigen::Vector3d& CenterOf(const ObjectEvent& event) { return event.center_world; }

const Eigen::Vector3d& CenterOf(const MapObject* object) { return object->cuboid.center_world; }

bool Matches(const RoomObject& expected, const MapObject* object, const RoomTolerance& tolerance) {
  if (tolerance.compares_classes && object->class_id != expected.class_id) return false;
  const Eigen::Vector3d& center_world = object->cuboid.center_world;
  if (expected.is_furniture) return IsNear(center_world, expected.box_world, kFurnitureMarginM);
  return (center_world - expected.box_world.center()).norm() <= tolerance.place_m;
}

/// Returns the place in `found` of what each part of the truth is matched with, one to one.
template <typename Truth, typename Found>
std::vector<std::optional<std::size_t>> MatchTruth(const std::vector<Truth>& truths,
                                                   const std::vector<Found>& found,
                                                   const RoomTolerance& tolerance) {
  std::vector<AssignmentPair> pairs;
  for (std::size_t row = 0; row < truths.size(); ++row) {
    const Truth& truth = truths[row];
    for (std::size_t column = 0; column < found.size(); ++column) {
      if (!Matches(truth, found[column], tolerance)) continue;
      const double distance_m = (CenterOf(found[column]) - truth.box_world.center()).norm();
      pairs.push_back({row, column, distance_m + (truth.is_required ? 0.0 : kOptionalM)});
    }
  }
  return AssignColumns(truths.size(), found.size(), pairs, kUnmatchedM);
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
  const std::vector<std::optional<std::size_t>> matches =
      MatchTruth(room.events, events, tolerance);
  for (std::size_t i = 0; i < room.events.size(); ++i) {
    const RoomEvent& truth = room.events[i];
    if (matches[i]) used[*matches[i]] = true;
    if (matches[i] || !truth.is_required) continue;
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

void ScoreObjects(const BoxRoom& room,
                  const MapSnapshot& map,
                  const RoomTolerance& tolerance,
                  RoomScore* score) {
  std::vector<const MapObject*> present;
  for (const auto& [id, object] : map.objects) {
    if (object->status == ObjectStatus::kPresent) present.push_back(object.get());
  }
  std::vector<bool> used(present.size(), false);
  const std::vector<std::optional<std::size_t>> matches =
      MatchTruth(room.objects, present, tolerance);
  for (std::size_t i = 0; i < room.objects.size(); ++i) {
    const RoomObject& truth = room.objects[i];
    if (!matches[i]) {
      if (!truth.is_required) continue;
      score->object_faults.push_back(absl::StrFormat("missing object of class %d at %s",
                                                     truth.class_id.value(),
                                                     PlaceText(truth.box_world.center())));
      continue;
    }
    used[*matches[i]] = true;
    if (!truth.is_furniture) {
      const Cuboid& cuboid = present[*matches[i]]->cuboid;
      const double error_m = CuboidErrorM(cuboid, truth.box_world);
      score->worst_cuboid_m = std::max(score->worst_cuboid_m, error_m);
      if (error_m > tolerance.cuboid_m) {
        const Eigen::AlignedBox3d box_world = AlignedBoxOf(cuboid);
        score->cuboid_faults.push_back(
            absl::StrFormat("cuboid of class %d: lowest corner off by %s m, highest by %s m",
                            truth.class_id.value(),
                            PlaceText(box_world.min() - truth.box_world.min()),
                            PlaceText(box_world.max() - truth.box_world.max())));
      }
    }
  }
  for (std::size_t i = 0; i < present.size(); ++i) {
    const MapObject* object = present[i];
    if (used[i]) continue;
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

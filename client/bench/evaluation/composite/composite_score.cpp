#include "client/bench/evaluation/composite/composite_score.h"

#include <algorithm>
#include <limits>

#include <absl/strings/str_format.h>

#include "client/bench/evaluation/room/room_score.h"
#include "client/bench/evaluation/score/event_faults.h"
#include "client/bench/evaluation/truth/place_text.h"
#include "client/bench/evaluation/truth/point_index.h"

namespace steadymap {
namespace {

// An object farther from a thing is another one.
constexpr double kSameThingM = 0.2;

/// Returns the present object whose cuboid is nearest to a box; null if none is near.
const MapObject* FindObject(const MapSnapshot& map, const Eigen::AlignedBox3d& box_world) {
  const MapObject* nearest = nullptr;
  double least_m = kSameThingM;
  for (const auto& [id, object] : map.objects) {
    if (object->status != ObjectStatus::kPresent) continue;
    const double distance_m = (object->cuboid.center_world - box_world.center()).norm();
    if (distance_m >= least_m) continue;
    least_m = distance_m;
    nearest = object.get();
  }
  return nearest;
}

void ScoreCuboids(const CompositeTruth& truth, const MapSnapshot& map, CompositeScore* score) {
  for (const SceneObject& thing : truth.things.after.objects()) {
    const Eigen::AlignedBox3d box_world = BoxOf(thing);
    const MapObject* object = FindObject(map, box_world);
    const double error_m = object == nullptr ? std::numeric_limits<double>::infinity()
                                             : CuboidErrorM(object->cuboid, box_world);
    score->cuboids += {error_m <= truth.cuboid_m ? 1U : 0U, 1U};
    if (error_m <= truth.cuboid_m) continue;
    const std::string place = PlaceText(box_world.center());
    score->faults.push_back(object == nullptr
                                ? absl::StrFormat("no object at %s", place)
                                : absl::StrFormat("cuboid at %s off by %.3f m", place, error_m));
  }
}

std::vector<SurfacePoint> SurfaceOf(const SceneObject& thing, double spacing_m) {
  return SampleFacets(FacetsOf(thing.shape, thing.T_world_object), spacing_m);
}

/// Adds up the surface of things that is not true any more, and whether the map has it.
void ScoreGhosts(const CompositeTruth& truth, const PointIndex& map, CompositeScore* score) {
  PointIndex now(truth.spacing_m);
  now.Add(truth.room);
  for (const SceneObject& thing : truth.things.after.objects()) {
    now.Add(SurfaceOf(thing, 0.5 * truth.spacing_m));
  }
  for (const SceneObject& thing : truth.things.before.objects()) {
    for (const SurfacePoint& point : SurfaceOf(thing, 0.5 * truth.spacing_m)) {
      if (now.HasNear(point.position_world)) continue;
      score->ghosts += {map.HasNear(point.position_world) ? 1U : 0U, 1U};
    }
  }
}

}  // namespace

CompositeScore& CompositeScore::operator+=(const CompositeScore& other) {
  events += other.events;
  moves += other.moves;
  cuboids += other.cuboids;
  ghosts += other.ghosts;
  kept += other.kept;
  poses += other.poses;
  faults.insert(faults.end(), other.faults.begin(), other.faults.end());
  return *this;
}

EventTruth ListCompositeEvents(const CompositeCase& things, ClassId class_id) {
  EventTruth truth;
  for (const PlacedThing& thing : things.things) {
    if (thing.change == ThingChange::kNone) continue;
    TrueChange change;
    change.name = NameOf(thing.change);
    change.class_id = class_id;
    change.sequence = 1;
    if (const SceneObject* before = things.before.Find(thing.id); before != nullptr) {
      change.departure = {{BoxOf(*before)}, true, {}};
    }
    if (const SceneObject* after = things.after.Find(thing.id); after != nullptr) {
      change.arrival = {{BoxOf(*after)}, true, {}};
    }
    truth.changes.push_back(std::move(change));
  }
  return truth;
}

CompositeScore ScoreComposite(const CompositeTruth& truth, const MethodOutcome& outcome) {
  CompositeScore score;
  const DetectionScores events = ScoreEvents(truth.events, outcome.events).one_to_one;
  score.events = events.all();
  score.moves = events.moved.found;
  score.faults = ListEventFaults(truth.events, outcome.events);
  score.poses = ScorePoses(truth.recorded, outcome.registered);
  ScoreCuboids(truth, *outcome.map, &score);
  PointIndex map(truth.spacing_m);
  map.Add(outcome.surface);
  ScoreGhosts(truth, map, &score);
  for (const SurfacePoint& point : truth.room) {
    score.kept += {map.HasNear(point.position_world) ? 1U : 0U, 1U};
  }
  return score;
}

}  // namespace steadymap

#include "core/objects/legs.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "core/objects/outline.h"
#include "core/objects/surface_parts.h"
#include "core/objects/unsegmented_surface.h"

namespace steadymap {
namespace {

/// The surface of other objects beside a leg, world frame, metres.
struct SurfaceBesideLeg {
  std::vector<Eigen::Vector3d> supports;       ///< Of other classes: the leg ends there.
  std::vector<Eigen::Vector3d> continuations;  ///< Of its class, in no segment.
};

SurfaceBesideLeg FindSurfaceBeside(const TrackedObject& leg,
                                   double reach_m,
                                   const WorkingMap& map) {
  SurfaceBesideLeg beside;
  const Box reach_world = Grow(leg.BoundsInWorld(), reach_m);
  for (const TrackedObject* other : map.ObjectsNear(reach_world)) {
    // What another session saw is not decided.
    const bool is_tentative = other->state().status == ObjectStatus::kTentative;
    if (other->is_archived() || (is_tentative && other->state().source != leg.state().source)) {
      continue;
    }
    const bool is_of_class = IsOfOneClass(*other, leg);
    if (is_of_class && !IsUnsegmented(*other)) continue;
    std::vector<Eigen::Vector3d>& points = is_of_class ? beside.continuations : beside.supports;
    for (const Eigen::Vector3d& point : other->SurfaceInWorld()) {
      if (reach_world.contains(point)) points.push_back(point);
    }
  }
  return beside;
}

double LengthOf(const TrackedObject& object) { return object.cuboid().size_m.maxCoeff(); }

}  // namespace

bool IsOpenLeg(const TrackedObject& object,
               const SessionPartParameters& parameters,
               const WorkingMap& map) {
  const Eigen::Vector3d lengths_m = PrincipalAxesOf(OrientedSurfaceOf(object)).lengths_m;
  if (lengths_m.y() >
      std::min(parameters.max_leg_width_m, parameters.scene.max_leg_share * lengths_m.x())) {
    return false;
  }
  const SurfaceBesideLeg beside = FindSurfaceBeside(object, parameters.max_gap_m, map);
  return OutlineTest(map, beside.supports)
      .HasUnseenEnd(OrientedSurfaceOf(object), beside.continuations);
}

bool MayBeLegOf(const TrackedObject& leg,
                const TrackedObject& other,
                const SessionPartParameters& parameters) {
  const double reach_m =
      std::min(parameters.max_leg_gap_m, LengthOf(leg) + std::min(LengthOf(leg), LengthOf(other)));
  return IsOfOneClass(leg, other) && DistanceBetween(leg.cuboid(), other.cuboid()) < reach_m;
}

TrackedObject* FindWholeOfLeg(const TrackedObject& leg,
                              const std::vector<TrackedObject*>& objects,
                              const SessionPartParameters& parameters) {
  TrackedObject* nearest = nullptr;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (TrackedObject* object : objects) {
    if (object == &leg || !MayBeLegOf(leg, *object, parameters)) continue;
    const double distance_m = DistanceBetween(leg.cuboid(), object->cuboid());
    if (distance_m >= nearest_m) continue;
    nearest = object;
    nearest_m = distance_m;
  }
  return nearest;
}

void JoinLegs(const SessionPartParameters& parameters, const SensorName& source, WorkingMap* map) {
  std::vector<TrackedObject*> objects;
  std::vector<TrackedObject*> legs;
  for (TrackedObject* object : map->TentativeObjectsOf(source)) {
    if (IsUnsegmented(*object)) continue;
    objects.push_back(object);
    if (IsOpenLeg(*object, parameters, *map)) legs.push_back(object);
  }
  while (true) {
    TrackedObject* leg = nullptr;
    TrackedObject* whole = nullptr;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (TrackedObject* candidate : legs) {
      TrackedObject* found = FindWholeOfLeg(*candidate, objects, parameters);
      if (found == nullptr) continue;
      const double distance_m = DistanceBetween(candidate->cuboid(), found->cuboid());
      if (distance_m >= nearest_m) continue;
      leg = candidate;
      whole = found;
      nearest_m = distance_m;
    }
    if (leg == nullptr) return;
    JoinSessionObjects(leg, whole, map);
    std::erase(objects, leg);
    std::erase(legs, leg);
  }
}

}  // namespace steadymap

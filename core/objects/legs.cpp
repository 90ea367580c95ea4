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

/// An object of the session.
struct Part {
  TrackedObject* object = nullptr;
  bool is_open_leg = false;
};

/// Returns the place in `parts` of the nearest object that a leg may belong to, and its distance;
/// the place of the leg if there is none.
std::pair<std::size_t, double> FindWhole(const std::vector<Part>& parts,
                                         std::size_t leg,
                                         const SessionPartParameters& parameters) {
  std::size_t nearest = leg;
  double nearest_m = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i == leg || !MayBeLegOf(*parts[leg].object, *parts[i].object, parameters)) continue;
    const double distance_m =
        DistanceBetween(parts[leg].object->cuboid(), parts[i].object->cuboid());
    if (distance_m >= nearest_m) continue;
    nearest = i;
    nearest_m = distance_m;
  }
  return {nearest, nearest_m};
}

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

void JoinLegs(const SessionPartParameters& parameters, const SensorName& source, WorkingMap* map) {
  std::vector<Part> parts;
  for (TrackedObject* object : map->TentativeObjectsOf(source)) {
    if (!IsUnsegmented(*object)) parts.push_back({object, IsOpenLeg(*object, parameters, *map)});
  }
  while (true) {
    std::size_t leg = parts.size();
    std::size_t whole = parts.size();
    double nearest_m = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!parts[i].is_open_leg) continue;
      const auto [place, distance_m] = FindWhole(parts, i, parameters);
      if (place == i || distance_m >= nearest_m) continue;
      leg = i;
      whole = place;
      nearest_m = distance_m;
    }
    if (leg == parts.size()) return;
    JoinSessionObjects(parts[leg].object, parts[whole].object, map);
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(leg));
  }
}

}  // namespace steadymap

#include "core/objects/unsegmented_surface.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "core/change/surface_looks.h"
#include "core/objects/legs.h"
#include "core/objects/surface_parts.h"

namespace steadymap {
namespace {

/// Returns the objects of the session of a source that have the class of unsegmented surface.
std::vector<TrackedObject*> FindObjectsOfClass(const TrackedObject& surface,
                                               const SensorName& source,
                                               WorkingMap* map) {
  std::vector<TrackedObject*> objects;
  for (TrackedObject* object : map->TentativeObjectsOf(source)) {
    if (!IsUnsegmented(*object) && IsOfOneClass(*object, surface)) objects.push_back(object);
  }
  return objects;
}

/// Returns for each point of unsegmented surface the number of the object that it continues,
/// counted from 1; 0 if it continues none.
std::vector<std::size_t> FindContinued(std::span<const OrientedPoint> surface,
                                       const Box& surface_bounds_world,
                                       const std::vector<TrackedObject*>& objects,
                                       double reach_m) {
  std::vector<OrientedPoint> points(surface.begin(), surface.end());
  const Box reach_world = Grow(surface_bounds_world, reach_m);
  std::vector<std::pair<std::size_t, std::size_t>> seeds;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (!objects[i]->BoundsInWorld().intersects(reach_world)) continue;
    for (const OrientedPoint& point : OrientedSurfaceOf(*objects[i])) {
      if (!reach_world.contains(point.position_world)) continue;
      seeds.emplace_back(points.size(), i + 1);
      points.push_back(point);
    }
  }
  std::vector<std::size_t> part_of = SpreadParts(points, seeds, reach_m);
  part_of.resize(surface.size());
  return part_of;
}

/// Numbers the connected parts of the points that have no number, from `next` on. Returns the
/// number after the last.
std::size_t NumberRest(std::span<const OrientedPoint> points,
                       double reach_m,
                       std::size_t next,
                       std::vector<std::size_t>* part_of) {
  std::vector<char> is_numbered(points.size(), 0);
  std::transform(part_of->begin(), part_of->end(), is_numbered.begin(), [](std::size_t part) {
    return part == 0 ? '\0' : '\1';
  });
  for (const std::vector<std::size_t>& rest : FindConnectedParts(points, is_numbered, reach_m)) {
    for (const std::size_t index : rest) (*part_of)[index] = next;
    ++next;
  }
  return next;
}

/// Returns the nearest object of which a part is an open leg; null if there is none, or if the
/// label of the part was wrong.
TrackedObject* FindWholeOf(const TrackedObject& part,
                           const std::vector<TrackedObject*>& objects,
                           const SessionPartParameters& parameters,
                           const WorkingMap& map) {
  if (IsTooSmall(part, parameters) || CountLooks(part).is_doubtful() ||
      !IsOpenLeg(part, parameters, map)) {
    return nullptr;
  }
  return FindWholeOfLeg(part, objects, parameters);
}

/// Adds the parts of unsegmented surface to the objects to which they belong.
void AddToObjects(const SessionPartParameters& parameters,
                  const std::vector<TrackedObject*>& objects,
                  TrackedObject* surface,
                  WorkingMap* map) {
  const double reach_m = parameters.surface.contact_voxels * map->scale().voxel_size_m;
  const std::vector<OrientedPoint> points = OrientedSurfaceOf(*surface);
  std::vector<std::size_t> part_of =
      FindContinued(points, surface->BoundsInWorld(), objects, reach_m);
  const std::size_t end = NumberRest(points, reach_m, objects.size() + 1, &part_of);
  const std::vector<TrackedObject*> parts = DivideVoxels(surface, part_of, end - 1, map);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    TrackedObject* whole =
        i < objects.size() ? objects[i] : FindWholeOf(*parts[i], objects, parameters, *map);
    if (whole != nullptr) AddVoxels(*parts[i], map, whole);
    map->Delete(parts[i]);
  }
}

}  // namespace

bool IsUnsegmented(const TrackedObject& object) {
  return object.state().status == ObjectStatus::kTentative && object.state().supporting_frames == 0;
}

void AddUnsegmentedSurface(const SessionPartParameters& parameters,
                           const SensorName& source,
                           WorkingMap* map) {
  for (TrackedObject* surface : map->TentativeObjectsOf(source)) {
    if (!IsUnsegmented(*surface)) continue;
    AddToObjects(parameters, FindObjectsOfClass(*surface, source, map), surface, map);
    map->Delete(surface);
  }
}

}  // namespace steadymap

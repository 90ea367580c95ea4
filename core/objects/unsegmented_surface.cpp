#include "core/objects/unsegmented_surface.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/objects/session_parts.h"
#include "core/objects/surface_parts.h"

namespace steadymap {
namespace {

/// Adds the parts of unsegmented surface to the objects that they continue.
void AddToObjects(TrackedObject* surface,
                  const std::vector<TrackedObject*>& objects,
                  double reach_m,
                  WorkingMap* map) {
  std::vector<OrientedPoint> points = OrientedSurfaceOf(*surface);
  const std::size_t own_count = points.size();
  const Box reach_world = Grow(surface->BoundsInWorld(), reach_m);
  std::vector<std::pair<std::size_t, std::size_t>> seeds;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    for (const OrientedPoint& point : OrientedSurfaceOf(*objects[i])) {
      if (!reach_world.contains(point.position_world)) continue;
      seeds.emplace_back(points.size(), i + 1);
      points.push_back(point);
    }
  }
  std::vector<std::size_t> part_of = SpreadParts(points, seeds, reach_m);
  part_of.resize(own_count);
  const std::vector<TrackedObject*> parts = DivideVoxels(surface, part_of, objects.size(), map);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    AddVoxels(*parts[i], map, objects[i]);
    map->Delete(parts[i]);
  }
}

}  // namespace

bool IsUnsegmented(const TrackedObject& object) {
  return object.state().status == ObjectStatus::kTentative && object.state().supporting_frames == 0;
}

void AddUnsegmentedSurface(double contact_voxels, const SensorName& source, WorkingMap* map) {
  const double reach_m = contact_voxels * map->scale().voxel_size_m;
  for (TrackedObject* surface : map->TentativeObjectsOf(source)) {
    if (!IsUnsegmented(*surface)) continue;
    std::vector<TrackedObject*> objects;
    for (TrackedObject* object : map->TentativeObjectsOf(source)) {
      if (!IsUnsegmented(*object) && IsOfOneClass(*object, *surface) &&
          object->BoundsInWorld().intersects(Grow(surface->BoundsInWorld(), reach_m))) {
        objects.push_back(object);
      }
    }
    AddToObjects(surface, objects, reach_m, map);
    map->Delete(surface);
  }
}

}  // namespace steadymap

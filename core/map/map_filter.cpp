#include "core/map/map_filter.h"

#include <algorithm>

#include "core/geometry/cuboid.h"
#include "core/map/placed_volume.h"

namespace steadymap {
namespace {

template <typename Value>
bool IsWanted(const std::set<Value>& wanted, Value value) {
  return wanted.empty() || wanted.contains(value);
}

bool Touches(const Box& box_world, const Cuboid& cuboid) {
  return DistanceBetween(cuboid, {box_world.center(), box_world.sizes(), 0.0}) == 0.0;
}

}  // namespace

bool MapFilter::Shows(const ObjectState& object) const {
  if (object.status == ObjectStatus::kTentative) return false;
  if (object.status == ObjectStatus::kArchived && !archived) return false;
  if (!IsWanted(objects, object.id) || !IsWanted(classes, object.class_id)) return false;
  return boxes_world.empty() ||
         std::any_of(boxes_world.begin(), boxes_world.end(), [&](const Box& box_world) {
           return Touches(box_world, object.cuboid);
         });
}

bool MapFilter::ShowsBackground() const {
  return IsWanted(objects, kBackgroundId) && IsWanted(classes, ClassId());
}

bool MapFilter::ShowsBackgroundLeaf(LeafOrigin origin, const VoxelScale& scale) const {
  if (!ShowsBackground()) return false;
  return boxes_world.empty() ||
         std::any_of(boxes_world.begin(), boxes_world.end(), [&](const Box& box_world) {
           return LeafTouches(PlacedVolume(), origin, scale, box_world);
         });
}

bool MapFilter::Shows(const ObjectEvent& event) const {
  if (event.IsOfRobot()) return objects.empty() && classes.empty() && boxes_world.empty();
  const bool is_related = event.related != kBackgroundId && objects.contains(event.related);
  if (!is_related && !IsWanted(objects, event.object)) return false;
  if (!IsWanted(classes, event.class_id)) return false;
  return boxes_world.empty() ||
         std::any_of(boxes_world.begin(), boxes_world.end(), [&](const Box& box_world) {
           return box_world.contains(event.center_world) ||
                  (event.old_center_world && box_world.contains(*event.old_center_world));
         });
}

}  // namespace steadymap

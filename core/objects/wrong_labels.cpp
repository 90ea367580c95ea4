#include "core/objects/wrong_labels.h"

#include <algorithm>
#include <vector>

#include "core/objects/surface_overlap.h"

namespace steadymap {
namespace {

bool IsOfOther(const SurfaceOverlap& overlap, const SurfaceShares& shares) {
  return overlap.known_fit_share() >= shares.most() ||
         overlap.known_close_share() >= shares.majority;
}

}  // namespace

bool HasSurfaceOfOther(const TrackedObject& object,
                       const SensorName& source,
                       const SessionPartParameters& parameters,
                       const WorkingMap& map) {
  const SurfaceOverlap with_background =
      CompareWithBackground(object, map.background(), parameters.surface, map.scale());
  if (IsOfOther(with_background, parameters.shares)) return true;
  const std::vector<const TrackedObject*> others = map.ObjectsNear(
      Grow(object.BoundsInWorld(), parameters.surface.contact_voxels * map.scale().voxel_size_m));
  return std::any_of(others.begin(), others.end(), [&](const TrackedObject* other) {
    const ObjectState& state = other->state();
    if (other->is_archived() || IsOfOneClass(object, *other) ||
        (state.status == ObjectStatus::kTentative && !IsInSession(state, source))) {
      return false;
    }
    const Eigen::Isometry3d T_other_object =
        state.T_world_object.ToIsometry().inverse() * object.state().T_world_object.ToIsometry();
    return IsOfOther(
        CompareSurfaces(object, *other, T_other_object, parameters.surface, map.scale()),
        parameters.shares);
  });
}

}  // namespace steadymap

#include "core/objects/wrong_labels.h"

#include <algorithm>
#include <vector>

#include "core/objects/surface_overlap.h"

namespace steadymap {

bool HasSurfaceOfOther(const TrackedObject& object,
                       const SensorName& source,
                       const SessionPartParameters& parameters,
                       const WorkingMap& map) {
  const double min_share = parameters.shares.most();
  const SurfaceOverlap with_background =
      CompareWithBackground(object, map.background(), parameters.surface, map.scale());
  if (with_background.known_fit_share() >= min_share) return true;
  const std::vector<const TrackedObject*> others = map.ObjectsNear(object.BoundsInWorld());
  return std::any_of(others.begin(), others.end(), [&](const TrackedObject* other) {
    const ObjectState& state = other->state();
    if (other->is_archived() || IsOfOneClass(object, *other) ||
        (state.status == ObjectStatus::kTentative && !IsInSession(state, source))) {
      return false;
    }
    const Eigen::Isometry3d T_other_object =
        state.T_world_object.ToIsometry().inverse() * object.state().T_world_object.ToIsometry();
    return CompareSurfaces(object, *other, T_other_object, parameters.surface, map.scale())
               .known_fit_share() >= min_share;
  });
}

}  // namespace steadymap

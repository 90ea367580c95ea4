#include "core/objects/session_objects.h"

namespace steadymap {

double DoubtOf(const TrackedObject& known,
               const SessionObjects& objects,
               const SessionIdentityParameters& parameters) {
  const Eigen::Vector3d& center_world = known.cuboid().center_world;
  const double displacement_m = (objects.motion * center_world - center_world).norm();
  return displacement_m > parameters.max_displacement_m ? 0.0 : GoneShareOf(known);
}

bool IsOlderThanRemoval(const SeenObject& seen, const KnownObject& known) {
  return known.object->is_archived() &&
         seen.object->state().last_seen < known.object->state().in_place_since;
}

bool IsOlderThanLastLook(const SeenObject& seen, const KnownObject& known) {
  return !known.object->is_archived() &&
         seen.object->state().last_seen < known.object->state().last_seen;
}

}  // namespace steadymap

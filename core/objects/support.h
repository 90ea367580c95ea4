#pragma once

#include "core/objects/session_parts.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

namespace steadymap {

/// True if an object was seen down to the level background that it stands on: there is background
/// of the height of its lowest surface beside it. The bottom of the object is then known, also for
/// any other place where it stands.
bool StandsOnBackground(const TrackedObject& object,
                        const SessionPartParameters& parameters,
                        const WorkingMap& map);

}  // namespace steadymap

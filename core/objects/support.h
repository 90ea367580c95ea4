#pragma once

#include "core/objects/session_parts.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

namespace steadymap {

/// True if the session saw an object down to where it stands: beside its lowest surface there is
/// level background of that height. The bottom of the object is then known, and stays its bottom
/// wherever it stands.
bool StandsOnBackground(const TrackedObject& object,
                        const SessionPartParameters& parameters,
                        const WorkingMap& map);

}  // namespace steadymap

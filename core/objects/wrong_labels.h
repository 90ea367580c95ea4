#pragma once

#include "core/map/robot_state.h"
#include "core/objects/session_parts.h"
#include "core/working/working_map.h"

namespace steadymap {

/// True if the background, or an object of another class, known or of the session of a source, has
/// most of the surface of `object`, an object of the session. If the looks of the session found
/// `object` gone, its label was wrong: a thing that leaves takes its surface with it. Half of the
/// surface is not enough: so much of a thing on a floor is near that, with large voxels.
bool HasSurfaceOfOther(const TrackedObject& object,
                       const SensorName& source,
                       const SessionPartParameters& parameters,
                       const WorkingMap& map);

}  // namespace steadymap

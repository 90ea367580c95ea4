#pragma once

#include "core/map/robot_state.h"
#include "core/objects/session_parts.h"
#include "core/working/working_map.h"

namespace steadymap {

/// True if the background, or an object of another class, known or of the session of a source, has
/// the surface of `object`, an object of the session: the majority of it within the error of two
/// looks, or most of it within the noise of single frames. If the looks of the session found
/// `object` gone, its label was wrong: a thing that leaves takes its surface with it. With large
/// voxels, half of a thing on a floor is within the noise of that floor.
bool HasSurfaceOfOther(const TrackedObject& object,
                       const SensorName& source,
                       const SessionPartParameters& parameters,
                       const WorkingMap& map);

}  // namespace steadymap

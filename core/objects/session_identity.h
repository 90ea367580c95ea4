#pragma once

#include "core/objects/session_parameters.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Decides what the objects of a session (status `kTentative`) are: known objects in place, known
/// objects at a new place, removed objects that are back, or new ones; and which known objects are
/// gone. Reports one event per change. Afterwards no object is tentative, and of the evidence for
/// an object only the sums are left.
void DecideSession(const MapConfig& config,
                   const SessionIdentityParameters& parameters,
                   WorkingMap* map);

}  // namespace steadymap

#pragma once

#include <optional>

#include "core/map/robot_state.h"
#include "core/objects/session_parameters.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Decides what the objects of the session of a source (status `kTentative`) are: known objects in
/// place, known objects at a new place, removed objects that are back, or new ones; and which known
/// objects are gone, by the looks of the session. Reports one event per change. What another
/// session saw later prevails. Afterwards no object of the session is tentative, and of the
/// evidence for a known object only the sums are left. Objects of other sessions are not touched.
///
/// Returns the offset of the poses of the session, which its objects were corrected by; its time is
/// not set. None if there are no known objects in place.
std::optional<PoseOffset> DecideSession(const MapConfig& config,
                                        const SessionIdentityParameters& parameters,
                                        const SensorName& source,
                                        WorkingMap* map);

}  // namespace steadymap

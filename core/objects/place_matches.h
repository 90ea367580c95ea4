#pragma once

#include <vector>

#include "core/objects/session_objects.h"
#include "core/objects/session_parameters.h"
#include "core/volume/tsdf_grid.h"

/// Which known object an object of a session is if it stands where that one stood.
namespace steadymap {

/// Returns the known objects that each undecided object of the session may be, in place or almost:
/// those that stand before the removed ones, then by their fit.
std::vector<PlaceMatch> FindPlaceMatches(const SessionIdentityParameters& parameters,
                                         const VoxelScale& scale,
                                         SessionObjects* objects);

/// Returns the displacement, metres, up to which an object of the session stands where it stood:
/// most things do, so that the displacements of the others tell the error of the poses.
double InPlaceLimit(const std::vector<PlaceMatch>& matches,
                    const SeenObject& seen,
                    const SessionIdentityParameters& parameters);

}  // namespace steadymap

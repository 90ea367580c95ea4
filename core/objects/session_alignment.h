#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/map/robot_state.h"
#include "core/objects/session_parameters.h"
#include "core/registration/registration.h"
#include "core/working/tracked_object.h"

/// Where the robot of a session was, by the objects that stand where they stood.
namespace steadymap {

/// Registers an object of a session to a known one; none if they are of different classes or far
/// apart.
std::optional<Registration> RegisterToKnown(const TrackedObject& seen,
                                            const TrackedObject& known,
                                            const VoxelScale& scale);

/// Returns the largest displacement that a correction means for an object, along the ground: what
/// stands there does not rise or sink. Metres.
double DisplacementOf(const Registration& registration, const TrackedObject& object);

/// Returns the largest displacement of an object by a motion of the world frame, also upwards and
/// downwards: it may come down when what it stood on is taken away. Metres.
double DisplacementOf(const Eigen::Isometry3d& motion, const TrackedObject& object);

/// True if an object of a session fits a known one without the correction: with it, the mean square
/// distance of the surfaces is lower by no more than the error of two looks at a thing in place, or
/// than what remains of it, which is the noise of the sensor.
bool FitsAtRest(const Registration& registration,
                const SessionIdentityParameters& parameters,
                const VoxelScale& scale);

/// True if a correction shows that an object of a session is not where a known one stood: it is
/// beyond the error of a registered frame, and the surfaces agree better with it than without.
bool IsDisplaced(const Registration& registration,
                 const TrackedObject& seen,
                 const TrackedObject& known,
                 const SessionIdentityParameters& parameters,
                 const VoxelScale& scale);

/// Finds the offset of the poses of a session by the known objects in place. None if there are
/// none; the time of the result is not set.
std::optional<PoseOffset> AlignSession(const std::vector<const TrackedObject*>& seen,
                                       const std::vector<const TrackedObject*>& known,
                                       const SessionIdentityParameters& parameters,
                                       const VoxelScale& scale);

}  // namespace steadymap

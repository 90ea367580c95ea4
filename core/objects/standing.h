#pragma once

#include <vector>

#include "core/objects/session_parameters.h"
#include "core/working/tracked_object.h"

/// Whether a known object still stands in its place, by the looks of a session.
namespace steadymap {

/// The verdict on a known object.
enum class Standing {
  kUnknown,  ///< It was hardly looked at.
  kStands,
  kUnverified,  ///< What was found of it is the surface of an object that hides the rest.
  kGone,
  kContradicted,  ///< It is gone for this sensor, and stands for another one.
};

/// True if the cuboids of two objects have a substantial share of the smaller one in common.
bool ShareSpace(const TrackedObject& a, const TrackedObject& b, const SurfaceShares& shares);

/// Returns the share of the looked-at surface that is gone; 0 without looks.
double GoneShareOf(const TrackedObject& object);

/// Judges a known object. `others` are the objects of the session of its class that are not yet
/// assigned. Surface that was found counts only if it is not theirs: of an object that was pushed
/// along its own plane, the looks find a part in the old place.
Standing JudgeStanding(const TrackedObject& known,
                       const std::vector<const TrackedObject*>& others,
                       const SessionIdentityParameters& parameters,
                       const VoxelScale& scale);

}  // namespace steadymap

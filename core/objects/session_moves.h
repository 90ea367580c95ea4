#pragma once

#include <vector>

#include "core/objects/session_objects.h"
#include "core/objects/session_parameters.h"
#include "core/objects/shape_match.h"
#include "core/working/working_map.h"

/// Which known object an object of a session is if that one is at a new place.
namespace steadymap {

/// An object of the session that has the shape of a known one, which is gone or was removed.
struct SessionMove {
  SeenObject* seen = nullptr;
  KnownObject* known = nullptr;
  ShapeMatch match;
};

/// Returns the moves of undecided objects of the session without which the best explanation of all
/// changes would be clearly worse; twins are not guessed. `free_space`: seen by the session. Drops
/// the doubted matches in place that a push explains better.
std::vector<SessionMove> FindSessionMoves(const SessionIdentityParameters& parameters,
                                          const FreeSpaceSince& free_space,
                                          const WorkingMap& map,
                                          SessionObjects* objects);

}  // namespace steadymap

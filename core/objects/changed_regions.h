#pragma once

#include <vector>

#include "core/objects/session_parts.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

/// What changed of an object whose extent no label tells: its connected surface may be of many
/// things, one of which came or left.
namespace steadymap {

/// Makes objects of the regions of a known object that most looks found gone. What was not looked
/// at belongs to the nearest region along the surface. The new objects have the state of the known
/// one.
std::vector<TrackedObject*> SeparateGoneRegions(const SessionPartParameters& parameters,
                                                TrackedObject* known,
                                                WorkingMap* map);

/// Makes objects of the regions of an object of the session, which stands in the place of a known
/// one, that were not there when the known one was seen: in front of its surface, or with space
/// behind them that was free. The new objects have the state of the one of the session.
std::vector<TrackedObject*> SeparateNewRegions(const SessionPartParameters& parameters,
                                               const TrackedObject& known,
                                               TrackedObject* seen,
                                               WorkingMap* map);

/// Returns the share of the surface of `seen`, an object of a session, where nothing was when
/// `known` and the background were seen, in [0, 1]; what they do not tell of does not count.
double NewShareOf(const SessionPartParameters& parameters,
                  const TrackedObject& known,
                  const TrackedObject& seen,
                  const WorkingMap& map);

}  // namespace steadymap

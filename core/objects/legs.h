#pragma once

#include <vector>

#include "core/objects/session_parts.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

/// Legs and posts of one object look like objects of their own where what connects them is out of
/// view, or too narrow for a segment.
namespace steadymap {

/// True if an object is slender and one of its ends was not seen: it goes on there. What was seen
/// from end to end, such as a bollard, is whole.
bool IsOpenLeg(const TrackedObject& object,
               const SessionPartParameters& parameters,
               const WorkingMap& map);

/// True if an open leg may belong to another object: one of its class, and not too far from it.
bool MayBeLegOf(const TrackedObject& leg,
                const TrackedObject& other,
                const SessionPartParameters& parameters);

/// Returns the nearest of the objects, other than the leg, that an open leg may belong to; null if
/// there is none.
TrackedObject* FindWholeOfLeg(const TrackedObject& leg,
                              const std::vector<TrackedObject*>& objects,
                              const SessionPartParameters& parameters);

/// Joins the open legs of a session, each with the nearest object that it may belong to.
void JoinLegs(const SessionPartParameters& parameters, const SensorName& source, WorkingMap* map);

}  // namespace steadymap

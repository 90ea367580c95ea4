#pragma once

#include "core/objects/session_objects.h"
#include "core/types/timestamp.h"
#include "core/working/working_map.h"

/// Sessions of the past: drives may arrive in any order, and what was seen later prevails.
namespace steadymap {

/// True if a known object was seen in a later session than one that ended at `end`: more than
/// `max_pause_s` later. What another sensor saw at the same time contradicts the session instead.
bool IsOfPast(const SessionObjects& objects, Timestamp end, double max_pause_s);

/// Finds which share of each object of a session of the past later sessions have looked through.
void FindRemovedSince(const WorkingMap& map, SessionObjects* objects);

/// Cuts that off an object.
void CutRemovedSince(const SeenObject& seen, WorkingMap* map);

}  // namespace steadymap

#pragma once

#include "core/objects/session_parts.h"
#include "core/working/working_map.h"

/// Surface of a session that no frame shows connected with an object: seen only at flat angles, or
/// in segments that are too narrow. It waits as an object of its class with no supporting frame, so
/// that it connects nothing; at the end of the session it goes to the objects that it continues.
namespace steadymap {

/// True if an object is unsegmented surface of a session.
bool IsUnsegmented(const TrackedObject& object);

/// Adds the unsegmented surface of the session of a source to the objects of its class. Each part
/// goes to the object from which the shortest way along the surface, in steps of at most
/// `surface.contact_voxels`, leads to it. What is connected with none may be an open leg of which
/// the upper end is hidden: it goes to the nearest object that it may belong to (`legs.h`). The
/// rest is deleted.
void AddUnsegmentedSurface(const SessionPartParameters& parameters,
                           const SensorName& source,
                           WorkingMap* map);

}  // namespace steadymap

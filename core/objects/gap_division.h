#pragma once

#include "core/objects/part_votes.h"
#include "core/objects/session_parts.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Divides the objects of the session of a source that have labels at the gaps between things
/// beside each other. Returns what follows for pairs of objects at a gap: what is on different
/// sides of it is apart; what is on one side of it in contact, or a fragment of the other, is of
/// one object. The votes on an object that was on both sides tell nothing of its pieces.
PartDecisions DivideAtGaps(const SessionPartParameters& parameters,
                           const SensorName& source,
                           WorkingMap* map);

}  // namespace steadymap

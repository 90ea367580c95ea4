#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/map/map_snapshot.h"
#include "core/map/object_event.h"
#include "core/types/identifiers.h"

namespace steadymap {

/// An event with its number in the map's history.
struct NumberedEvent {
  EventNumber number;
  ObjectEvent event;

  friend bool operator==(const NumberedEvent&, const NumberedEvent&) = default;
};

/// One complete step of a mirrored map.
struct MirrorStep {
  Revision previous_revision;     ///< Before the step.
  std::uint64_t commits = 0;      ///< Covered by the step; 0 if none passed the filter.
  bool is_snapshot = false;       ///< The step replaces the whole map.
  std::vector<ObjectId> objects;  ///< Added, changed or removed; ascending, unique.
  /// Leaves that were added, changed or removed, except those of removed objects; sorted, unique.
  std::vector<LeafKey> leaves;
  std::vector<NumberedEvent> events;  ///< In ascending order of number.
  std::string resume_token;
  std::shared_ptr<const MapSnapshot> map;  ///< After the step, never null.
};

}  // namespace steadymap

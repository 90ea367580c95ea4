#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/map/map_snapshot.h"
#include "core/map/object_event.h"
#include "core/types/identifiers.h"

namespace steadymap {

/// An event with its place in the map's history.
struct NumberedEvent {
  EventNumber number;
  ObjectEvent event;

  friend bool operator==(const NumberedEvent&, const NumberedEvent&) = default;
};

/// One whole step of a mirrored map.
struct MirrorStep {
  Revision previous_revision;         ///< What the mirror had.
  std::uint64_t commits = 0;          ///< That the step covers; 0 where nothing passed the filter.
  bool is_snapshot = false;           ///< Everything before was dropped.
  std::vector<ObjectId> objects;      ///< New, changed or gone; by rising id, no id twice.
  std::vector<LeafKey> leaves;        ///< New, changed or gone, but for those of objects that are
                                      ///< gone; sorted, no key twice.
  std::vector<NumberedEvent> events;  ///< By rising number.
  std::string resume_token;
  std::shared_ptr<const MapSnapshot> map;  ///< After the step, never null.
};

}  // namespace steadymap

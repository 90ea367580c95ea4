#include "core/map/object_event.h"

namespace steadymap {

std::string_view NameOf(EventType type) {
  switch (type) {
    case EventType::kCreated:
      return "created";
    case EventType::kUpdated:
      return "updated";
    case EventType::kMoved:
      return "moved";
    case EventType::kRemoved:
      return "removed";
    case EventType::kReturned:
      return "returned";
    case EventType::kMerged:
      return "merged";
    case EventType::kSplit:
      return "split";
    case EventType::kRobotLost:
      return "robot_lost";
    case EventType::kRobotFound:
      return "robot_found";
    case EventType::kContradicted:
      return "contradicted";
  }
  return "unknown";
}

std::string_view NameOf(EventReason reason) {
  switch (reason) {
    case EventReason::kNewSurface:
      return "new_surface";
    case EventReason::kSeenThrough:
      return "seen_through";
    case EventReason::kDisplaced:
      return "displaced";
    case EventReason::kReplaced:
      return "replaced";
    case EventReason::kShapeMatched:
      return "shape_matched";
    case EventReason::kConnected:
      return "connected";
    case EventReason::kDisconnected:
      return "disconnected";
    case EventReason::kDisagreement:
      return "disagreement";
    case EventReason::kAgreement:
      return "agreement";
  }
  return "unknown";
}

}  // namespace steadymap

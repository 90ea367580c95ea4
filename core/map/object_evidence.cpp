#include "core/map/object_evidence.h"

#include <algorithm>
#include <utility>

namespace steadymap {
namespace {

bool IsBefore(const LeafEvidence& leaf, LeafOrigin origin) { return leaf.origin < origin; }

/// Returns the first entry whose source is not before `source`.
std::vector<SessionLooks>::iterator PlaceOf(const SensorName& source,
                                            std::vector<SessionLooks>* looks) {
  return std::lower_bound(
      looks->begin(), looks->end(), source, [](const SessionLooks& entry, const SensorName& name) {
        return entry.source < name;
      });
}

}  // namespace

const LeafEvidence* ObjectEvidence::FindLeaf(LeafOrigin origin) const {
  const auto place = std::lower_bound(leaves.begin(), leaves.end(), origin, IsBefore);
  return place != leaves.end() && place->origin == origin ? &*place : nullptr;
}

LeafEvidence& ObjectEvidence::MutableLeaf(LeafOrigin origin) {
  const auto place = std::lower_bound(leaves.begin(), leaves.end(), origin, IsBefore);
  if (place != leaves.end() && place->origin == origin) return *place;
  return *leaves.insert(place, LeafEvidence{origin, {}, {}});
}

Timestamp LastLook(const std::vector<LeafEvidence>& leaves) {
  Timestamp last;
  for (const LeafEvidence& leaf : leaves) last = std::max(last, leaf.last_look);
  return last;
}

std::vector<LeafEvidence> TakeLooks(const SensorName& source, std::vector<SessionLooks>* looks) {
  const auto place = PlaceOf(source, looks);
  if (place == looks->end() || place->source != source) return {};
  std::vector<LeafEvidence> leaves = std::move(place->leaves);
  looks->erase(place);
  return leaves;
}

void StoreLooks(const SensorName& source,
                std::vector<LeafEvidence> leaves,
                std::vector<SessionLooks>* looks) {
  if (looks->size() >= kMaxLookingSessions) {
    looks->erase(std::min_element(
        looks->begin(), looks->end(), [](const SessionLooks& a, const SessionLooks& b) {
          return LastLook(a.leaves) < LastLook(b.leaves);
        }));
  }
  looks->insert(PlaceOf(source, looks), SessionLooks{source, std::move(leaves)});
}

}  // namespace steadymap

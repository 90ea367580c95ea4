#include "core/map/object_evidence.h"

#include <algorithm>

namespace steadymap {
namespace {

bool IsBefore(const LeafEvidence& leaf, LeafOrigin origin) { return leaf.origin < origin; }

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

}  // namespace steadymap

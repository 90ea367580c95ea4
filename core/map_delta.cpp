#include "core/map_delta.h"

#include <algorithm>
#include <cassert>
#include <map>

#include <absl/strings/str_cat.h>

#include "core/map_snapshot.h"
#include "core/tsdf_codec.h"

namespace steadymap {
namespace {

using PackedLeaves = std::map<LeafKey, std::string>;

PackedLeaves PackAll(const MapSnapshot& snapshot) {
  PackedLeaves packed;
  snapshot.background.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    packed.emplace(LeafKey{kBackgroundId, origin}, PackLeaf(leaf, snapshot.scale));
  });
  return packed;
}

}  // namespace

MapDelta Diff(const MapSnapshot& before, const MapSnapshot& after) {
  assert(before.scale == after.scale);
  MapDelta delta{before.revision, after.revision, after.last_capture_time, {}};
  PackedLeaves changes = PackAll(after);
  for (const auto& [key, packed] : PackAll(before)) {
    const auto [change, vanished] = changes.try_emplace(key);
    if (!vanished && change->second == packed) changes.erase(change);
  }
  for (auto& [key, packed] : changes) delta.leaves.push_back({key, std::move(packed)});
  return delta;
}

absl::Status Apply(const MapDelta& delta, MapSnapshot* snapshot) {
  if (snapshot->revision < delta.from || snapshot->revision > delta.to) {
    return absl::FailedPreconditionError(absl::StrCat("a delta from revision ",
                                                      delta.from.value(),
                                                      " to ",
                                                      delta.to.value(),
                                                      " does not apply to revision ",
                                                      snapshot->revision.value()));
  }
  LeafVoxels voxels;
  for (const LeafChange& change : delta.leaves) {
    if (absl::Status status = UnpackLeaf(change.packed, snapshot->scale, &voxels); !status.ok()) {
      return status;
    }
    snapshot->background.MutableTile(change.key.origin).StoreLeaf(change.key.origin, voxels);
  }
  snapshot->revision = delta.to;
  snapshot->last_capture_time = delta.last_capture_time;
  return absl::OkStatus();
}

MapDelta Merge(const MapDelta& first, const MapDelta& second) {
  assert(first.to == second.from);
  MapDelta merged{first.from, second.to, second.last_capture_time, {}, first.events};
  merged.events.insert(merged.events.end(), second.events.begin(), second.events.end());
  merged.leaves.reserve(first.leaves.size() + second.leaves.size());
  auto older = first.leaves.begin();
  for (const LeafChange& newer : second.leaves) {
    while (older != first.leaves.end() && older->key < newer.key) merged.leaves.push_back(*older++);
    if (older != first.leaves.end() && older->key == newer.key) ++older;
    merged.leaves.push_back(newer);
  }
  merged.leaves.insert(merged.leaves.end(), older, first.leaves.end());
  return merged;
}

}  // namespace steadymap

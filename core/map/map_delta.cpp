#include "core/map/map_delta.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/map/map_edits.h"
#include "core/volume/tsdf_codec.h"

namespace steadymap {
namespace {

using PackedLeaves = std::map<LeafKey, std::string>;

void PackVolume(ObjectId id, const VoxelReader& volume, PackedLeaves* packed) {
  volume.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    packed->emplace(LeafKey{id, origin}, PackLeaf(leaf));
  });
}

std::vector<LeafChange> DiffLeaves(const MapSnapshot& before, const MapSnapshot& after) {
  PackedLeaves known;
  PackedLeaves changes;
  PackVolume(kBackgroundId, before.background, &known);
  PackVolume(kBackgroundId, after.background, &changes);
  ObjectLibrary::ForEachDifference(
      before.objects, after.objects, [&](ObjectId id, const MapObject* old, const MapObject* now) {
        if (old != nullptr) PackVolume(id, *old->volume, &known);
        if (now != nullptr) PackVolume(id, *now->volume, &changes);
      });
  for (const auto& [key, packed] : known) {
    const auto [change, vanished] = changes.try_emplace(key);
    if (!vanished && change->second == packed) changes.erase(change);
  }
  std::vector<LeafChange> leaves;
  leaves.reserve(changes.size());
  for (auto& [key, packed] : changes) leaves.push_back({key, std::move(packed)});
  return leaves;
}

std::vector<ObjectChange> DiffObjects(const MapSnapshot& before, const MapSnapshot& after) {
  std::vector<ObjectChange> objects;
  ObjectLibrary::ForEachDifference(
      before.objects, after.objects, [&](ObjectId id, const MapObject* old, const MapObject* now) {
        if (now == nullptr) {
          objects.push_back({id, std::nullopt});
        } else if (const ObjectState& state = *now;
                   old == nullptr || static_cast<const ObjectState&>(*old) != state) {
          objects.push_back({id, state});
        }
      });
  return objects;
}

std::vector<FreeBlockChange> DiffFreeSpace(const FreeSpace& before, const FreeSpace& after) {
  std::map<LeafOrigin, FreeBlock> changes;
  before.ForEachBlock([&](LeafOrigin origin, const FreeBlock&) { changes[origin] = {}; });
  after.ForEachBlock([&](LeafOrigin origin, const FreeBlock& block) { changes[origin] = block; });
  std::vector<FreeBlockChange> blocks;
  for (const auto& [origin, block] : changes) {
    if (before.FindBlock(origin) != block) blocks.push_back({origin, block});
  }
  return blocks;
}

std::vector<RobotChange> DiffRobots(const MapSnapshot& before, const MapSnapshot& after) {
  std::map<SensorName, std::optional<RobotState>> changes;
  for (const auto& [robot, state] : before.robots) changes[robot] = std::nullopt;
  for (const auto& [robot, state] : after.robots) {
    const auto old = before.robots.find(robot);
    if (old != before.robots.end() && old->second == state) {
      changes.erase(robot);
    } else {
      changes[robot] = state;
    }
  }
  std::vector<RobotChange> robots;
  robots.reserve(changes.size());
  for (const auto& [robot, state] : changes) robots.push_back({robot, state});
  return robots;
}

/// Merges two lists sorted by `key`. An element of `second` replaces an element of `first` with an
/// equal key.
template <typename Change, typename Key>
std::vector<Change> MergeSorted(const std::vector<Change>& first,
                                const std::vector<Change>& second,
                                Key key) {
  std::vector<Change> merged;
  merged.reserve(first.size() + second.size());
  auto older = first.begin();
  for (const Change& newer : second) {
    while (older != first.end() && key(*older) < key(newer)) merged.push_back(*older++);
    if (older != first.end() && key(*older) == key(newer)) ++older;
    merged.push_back(newer);
  }
  merged.insert(merged.end(), older, first.end());
  return merged;
}

}  // namespace

MapDelta Diff(const MapSnapshot& before, const MapSnapshot& after) {
  assert(before.scale == after.scale);
  return {.from = before.revision,
          .to = after.revision,
          .last_capture_time = after.last_capture_time,
          .newest_object = after.newest_object,
          .last_event = after.last_event,
          .added_classes = after.added_classes,
          .objects = DiffObjects(before, after),
          .leaves = DiffLeaves(before, after),
          .free_blocks = DiffFreeSpace(before.free_space, after.free_space),
          .robots = DiffRobots(before, after)};
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
  MapEdits edits(snapshot);
  for (const ObjectChange& change : delta.objects) {
    if (change.state.has_value()) {
      edits.SetState(*change.state);
    } else {
      edits.RemoveObject(change.id);
    }
  }
  for (const LeafChange& change : delta.leaves) {
    if (absl::Status status = edits.StoreLeaf(change.key, change.packed); !status.ok()) {
      return status;
    }
  }
  edits.Finish();
  for (const FreeBlockChange& change : delta.free_blocks) {
    snapshot->free_space.StoreBlock(change.origin, change.block);
  }
  for (const RobotChange& change : delta.robots) {
    if (change.state.has_value()) {
      snapshot->robots[change.sensor] = *change.state;
    } else {
      snapshot->robots.erase(change.sensor);
    }
  }
  snapshot->revision = delta.to;
  snapshot->last_capture_time = delta.last_capture_time;
  snapshot->newest_object = delta.newest_object;
  snapshot->last_event = delta.last_event;
  snapshot->added_classes = delta.added_classes;
  return absl::OkStatus();
}

MapDelta Merge(const MapDelta& first, const MapDelta& second) {
  assert(first.to == second.from);
  MapDelta merged{
      .from = first.from,
      .to = second.to,
      .last_capture_time = second.last_capture_time,
      .newest_object = second.newest_object,
      .last_event = second.last_event,
      .added_classes = second.added_classes,
      .objects = MergeSorted(
          first.objects, second.objects, [](const ObjectChange& change) { return change.id; }),
      .leaves = MergeSorted(
          first.leaves, second.leaves, [](const LeafChange& change) { return change.key; }),
      .free_blocks = MergeSorted(first.free_blocks,
                                 second.free_blocks,
                                 [](const FreeBlockChange& change) { return change.origin; }),
      .robots = MergeSorted(
          first.robots, second.robots, [](const RobotChange& change) { return change.sensor; }),
      .events = first.events};
  merged.events.insert(merged.events.end(), second.events.begin(), second.events.end());
  return merged;
}

}  // namespace steadymap

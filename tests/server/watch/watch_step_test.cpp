#include "server/watch/watch_step.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/map/map_delta.h"
#include "core/volume/tsdf_codec.h"
#include "tests/server/store/store_builder.h"
#include "tests/support/packed_leaf.h"

namespace steadymap {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::string Patched(const std::string& packed, const std::string& patch) {
  v1::PackedLeaf message;
  message.set_packed(patch);
  message.set_is_patch(true);
  return patch.empty() ? packed : testing::TakePackedLeaf(message, packed).value_or("");
}

/// State of a watcher: object states and packed leaves in their wire form.
struct WatcherView {
  std::map<ObjectId, ObjectState> objects;
  std::map<LeafKey, std::string> leaves;

  void Take(const StepPlan& step) {
    for (const ObjectId id : step.removed) {
      objects.erase(id);
      std::erase_if(leaves, [&](const auto& leaf) { return leaf.first.object == id; });
    }
    for (const ObjectId id : step.objects) objects[id] = *step.snapshot->objects.at(id);
    for (const LeafKey& key : step.leaves) {
      const auto patch = step.FindPatch(key);
      const LeafView leaf = patch ? *patch : FindLeaf(*step.snapshot, key);
      const std::string packed = PackLeaf(leaf);
      if (patch) {
        leaves.at(key) = Patched(leaves.at(key), packed);
      } else if (packed.empty()) {
        leaves.erase(key);
      } else {
        leaves[key] = packed;
      }
    }
  }

  friend bool operator==(const WatcherView&, const WatcherView&) = default;
};

/// Returns the filtered content of a map, found by a full scan.
WatcherView Truth(const MapFilter& filter, const MapSnapshot& map) {
  WatcherView view;
  if (filter.volumes) {
    map.background.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
      if (filter.ShowsBackgroundLeaf(origin, map.scale)) {
        view.leaves[{kBackgroundId, origin}] = PackLeaf(leaf);
      }
    });
  }
  if (!filter.WantsObjects()) return view;
  for (const auto& [id, object] : map.objects) {
    if (!filter.Shows(*object)) continue;
    view.objects[id] = *object;
    if (!filter.volumes) continue;
    object->volume->ForEachLeaf([&, id = id](LeafOrigin origin, const LeafView& leaf) {
      view.leaves[{id, origin}] = PackLeaf(leaf);
    });
  }
  return view;
}

/// A map with random changes: objects appear, disappear, move, change class and status.
class RestlessMap {
 public:
  explicit RestlessMap(std::uint32_t seed) : random_(seed), map_(VoxelScale{0.04, 0.12}) {}

  std::shared_ptr<const MapSnapshot> Snapshot() const {
    return std::make_shared<const MapSnapshot>(map_);
  }

  /// Commits a change of a few objects; returns its change list.
  ChangeList Change() {
    MapDelta delta;
    delta.from = map_.revision;
    delta.to = Revision(map_.revision.value() + 1 + Draw(3));
    std::map<ObjectId, std::optional<ObjectState>> objects;
    std::map<LeafKey, std::string> leaves;
    std::set<ObjectId> touched;
    for (std::uint32_t i = Draw(4); i > 0; --i) {
      const ObjectId id(1 + Draw(9));
      if (touched.insert(id).second) ChangeObject(id, &objects, &leaves);
    }
    for (std::uint32_t i = Draw(4); i > 0; --i) ChangeLeaf(kBackgroundId, &leaves);
    for (auto& [id, state] : objects) delta.objects.push_back({id, std::move(state)});
    for (auto& [key, packed] : leaves) delta.leaves.push_back({key, std::move(packed)});
    EXPECT_TRUE(Apply(delta, &map_).ok());
    ChangeList changes{.commits = 1};
    for (const ObjectChange& object : delta.objects) changes.objects.push_back(object.id);
    for (const LeafChange& leaf : delta.leaves) changes.leaves.push_back(leaf.key);
    return changes;
  }

  std::uint32_t Draw(std::uint32_t below) { return static_cast<std::uint32_t>(random_() % below); }

 private:
  void ChangeObject(ObjectId id,
                    std::map<ObjectId, std::optional<ObjectState>>* objects,
                    std::map<LeafKey, std::string>* leaves) {
    const auto known = map_.objects.find(id);
    const bool is_known = known != map_.objects.end();
    if (is_known && Draw(8) == 0) {
      (*objects)[id] = std::nullopt;
      known->second->volume->ForEachLeaf([&, id](LeafOrigin origin, const LeafView&) {
        (*leaves)[{id, origin}] = "";
      });
      return;
    }
    // Sometimes only leaves change.
    if (!is_known || Draw(3) > 0) {
      ObjectState state = MakeObject(id.value(), Draw(1000));
      state.status = static_cast<ObjectStatus>(Draw(3));
      state.class_id = ClassId(static_cast<std::uint16_t>(Draw(3)));
      state.cuboid = {{static_cast<double>(Draw(4)), 0.0, 0.0}, {0.5, 0.5, 0.5}, 0.0};
      (*objects)[id] = state;
    }
    for (std::uint32_t i = Draw(3); i > 0; --i) ChangeLeaf(id, leaves);
  }

  void ChangeLeaf(ObjectId id, std::map<LeafKey, std::string>* leaves) {
    const LeafChange leaf = MakeLeaf(static_cast<std::int32_t>(Draw(12)), 0, 0, Draw(1000));
    const LeafKey key{id, leaf.key.origin};
    const LeafView known = FindLeaf(map_, key);
    std::string& packed = (*leaves)[key];
    packed = leaf.packed;
    if (Draw(5) == 0) {
      packed.clear();
    } else if (known && Draw(3) > 0) {
      packed = Patched(PackLeaf(known), leaf.packed);
    }
  }

  std::mt19937 random_;
  MapSnapshot map_;
};

MapFilter RandomFilter(RestlessMap* random) {
  MapFilter filter;
  const auto box = [](double x_m) {
    return Box(Eigen::Vector3d(x_m - 0.6, -1.0, -1.0), Eigen::Vector3d(x_m + 0.6, 1.0, 1.0));
  };
  if (random->Draw(2) == 0) filter.boxes_world.push_back(box(1.0));
  if (random->Draw(4) == 0) filter.boxes_world.push_back(box(3.0));
  if (random->Draw(3) == 0) filter.classes = {ClassId(0), ClassId(1)};
  if (random->Draw(3) == 0) filter.objects = {kBackgroundId, ObjectId(2), ObjectId(3), ObjectId(5)};
  filter.archived = random->Draw(2) == 0;
  filter.volumes = random->Draw(4) > 0;
  filter.states = random->Draw(2) == 0;
  return filter;
}

TEST(WatchStep, StepsLeadToWhatTheFilterShowsWhateverHappens) {
  std::size_t patches = 0;
  for (std::uint32_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    RestlessMap map(seed);
    const MapFilter filter = RandomFilter(&map);
    WatcherView view;
    StepPlan step = MakeSnapshotStep(filter, map.Snapshot());
    view.Take(step);
    for (int i = 0; i < 40; ++i) {
      const Revision from = step.snapshot->revision;
      ChangeList changes = map.Change();
      // Sometimes the watcher's content is unknown, as after a restart.
      const auto shown = map.Draw(6) == 0 ? nullptr : step.shown;
      const std::shared_ptr<const MapSnapshot> before = step.snapshot;
      step = MakeDeltaStep(filter, changes, from, shown, map.Snapshot());
      // Sometimes the previous map is unknown, too.
      if (map.Draw(4) > 0) step.base = before;
      view.Take(step);
      for (const LeafKey& key : step.leaves) patches += step.FindPatch(key) ? 1 : 0;
      ASSERT_EQ(view, Truth(filter, *step.snapshot)) << "after change " << i;
      ASSERT_EQ(*step.shown, *ShownBy(filter, *step.snapshot));
    }
  }
  EXPECT_GT(patches, 100U);
}

TEST(WatchStep, SeveralCommitsInOneStepLeadToTheSame) {
  for (std::uint32_t seed = 100; seed < 130; ++seed) {
    SCOPED_TRACE(seed);
    RestlessMap map(seed);
    const MapFilter filter = RandomFilter(&map);
    WatcherView view;
    StepPlan step = MakeSnapshotStep(filter, map.Snapshot());
    view.Take(step);
    for (int i = 0; i < 10; ++i) {
      const Revision from = step.snapshot->revision;
      std::set<ObjectId> objects;
      std::set<LeafKey> leaves;
      for (std::uint32_t commits = 1 + map.Draw(6); commits > 0; --commits) {
        const ChangeList changes = map.Change();
        objects.insert(changes.objects.begin(), changes.objects.end());
        leaves.insert(changes.leaves.begin(), changes.leaves.end());
      }
      const ChangeList together{.commits = 2,
                                .objects = {objects.begin(), objects.end()},
                                .leaves = {leaves.begin(), leaves.end()}};
      const std::shared_ptr<const MapSnapshot> before = step.snapshot;
      step = MakeDeltaStep(filter, together, from, step.shown, map.Snapshot());
      step.base = before;
      view.Take(step);
      ASSERT_EQ(view, Truth(filter, *step.snapshot)) << "after step " << i;
    }
  }
}

TEST(WatchStep, NamesNothingThatTheFilterDoesNotShow) {
  for (std::uint32_t seed = 200; seed < 230; ++seed) {
    SCOPED_TRACE(seed);
    RestlessMap map(seed);
    const MapFilter filter = RandomFilter(&map);
    StepPlan step = MakeSnapshotStep(filter, map.Snapshot());
    for (int i = 0; i < 40; ++i) {
      const std::shared_ptr<const ShownObjects> shown = step.shown;
      const Revision from = step.snapshot->revision;
      const ChangeList changes = map.Change();
      step = MakeDeltaStep(filter, changes, from, shown, map.Snapshot());
      for (const ObjectId id : step.objects) {
        EXPECT_TRUE(filter.Shows(*step.snapshot->objects.at(id)));
      }
      for (const LeafKey& key : step.leaves) {
        EXPECT_TRUE(key.object == kBackgroundId
                        ? filter.ShowsBackgroundLeaf(key.origin, step.snapshot->scale)
                        : filter.Shows(*step.snapshot->objects.at(key.object)));
      }
      // If the watcher's content is known, tombstones name only objects it contains.
      for (const ObjectId id : step.removed) {
        EXPECT_TRUE(std::binary_search(shown->begin(), shown->end(), id));
      }
    }
  }
}

TEST(WatchStep, OfEventsAloneIsEmpty) {
  RestlessMap map(1);
  MapFilter filter;
  filter.states = filter.volumes = false;
  const StepPlan begin = MakeSnapshotStep(filter, map.Snapshot());
  EXPECT_TRUE(begin.IsEmpty());
  const ChangeList changes = map.Change();
  EXPECT_TRUE(MakeDeltaStep(filter, changes, Revision(), begin.shown, map.Snapshot()).IsEmpty());
}

}  // namespace
}  // namespace steadymap

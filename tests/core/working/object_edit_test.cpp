#include "core/working/object_edit.h"

#include <memory>
#include <random>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/map_delta.h"
#include "core/working/object_split.h"
#include "core/working/working_map.h"
#include "tests/core/policy/map_story.h"
#include "tests/core/volume/random_leaf.h"
#include "tests/support/default_scale.h"

namespace steadymap {
namespace {

using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::kScale;

// A TrackedObject cannot be modified without an edit.
static_assert(std::is_same_v<decltype(std::declval<TrackedObject&>().state()), const ObjectState&>);
static_assert(std::is_same_v<decltype(std::declval<TrackedObject&>().volume()), const TsdfGrid&>);
static_assert(!std::is_copy_assignable_v<TrackedObject>);
static_assert(!std::is_move_assignable_v<TrackedObject>);

/// Applies random edits of all kinds to a map.
class RandomEditor {
 public:
  explicit RandomEditor(unsigned seed) : random_(seed) {}

  /// Edits one random object.
  void Step(WorkingMap* map) {
    if (map->objects().size() < 6) {
      StoreLeaf(&map->AddObject(Position()), map);
      return;
    }
    TrackedObject* object = Any(map);
    switch (Integer(9)) {
      case 0:
        map->AddPart(*object);
        break;
      case 1:
        map->Delete(object);
        break;
      case 2:
        EditState(object, map);
        break;
      case 3:
        TakeVolume(*Any(map), object, map);
        break;
      case 4:
        Copy(*Any(map), object, map);
        break;
      case 5:
        Resample(*Any(map), object, map);
        break;
      case 6:
        MoveGone(object, map);
        break;
      case 7:
        ReadOnly(object, map);
        break;
      default:
        StoreLeaf(object, map);
        break;
    }
  }

  std::size_t Integer(std::size_t last) {
    return std::uniform_int_distribution<std::size_t>(0, last)(random_);
  }

 private:
  /// Writes or removes one leaf.
  void StoreLeaf(TrackedObject* object, WorkingMap* map) {
    ObjectEdit edit = map->Edit(object);
    const double probability = Integer(3) == 0 ? 0.0 : 0.5;
    edit.StoreLeaf(Origin(), RandomLeaf(&random_, probability, Integer(1) == 0, Integer(1) == 0));
  }

  /// Writes one random part of the state.
  void EditState(TrackedObject* object, WorkingMap* map) {
    ObjectEdit edit = map->Edit(object);
    ObjectState& state = edit.state();
    switch (Integer(5)) {
      case 0:
        state.T_world_object = {Position(), Integer(1) == 0 ? 0.0 : 0.3};
        break;
      case 1:
        if (!object->is_deleted()) state.status = static_cast<ObjectStatus>(Integer(2));
        break;
      case 2:
        state.belief.alpha += 1.0;
        break;
      case 3:
        state.evidence.MutableLeaf(Origin()).score.fill(1);
        break;
      case 4:
        state.votes = {{ClassId(static_cast<std::uint16_t>(Integer(9))), 1.0}};
        break;
      default:
        ++state.supporting_frames;
        break;
    }
  }

  static void TakeVolume(const TrackedObject& from, TrackedObject* into, WorkingMap* map) {
    ObjectEdit edit = map->Edit(into);
    edit.TakeVolume(from);
  }

  static void Copy(const TrackedObject& from, TrackedObject* into, WorkingMap* map) {
    if (&from == into || !ShareLattice(from.state(), into->state())) return;
    ObjectEdit edit = map->Edit(into);
    CopyVoxels(from, map->scale(), &edit);
  }

  static void Resample(const TrackedObject& from, TrackedObject* into, WorkingMap* map) {
    if (&from == into) return;
    ObjectEdit edit = map->Edit(into);
    ResampleVoxels(
        from, from.state().T_world_object.ToIsometry(), /*max_weight=*/1.0, map->scale(), &edit);
  }

  /// Moves some evidence cells to a new part.
  void MoveGone(TrackedObject* object, WorkingMap* map) {
    TrackedObject& part = map->AddPart(*object);
    ObjectEdit edit = map->Edit(object);
    ObjectEdit part_edit = map->Edit(&part);
    edit.state().evidence.MutableLeaf(Origin()).score[Integer(63)] = -9;
    MoveGoneVoxels({-5, -3}, &edit, &part_edit);
  }

  static void ReadOnly(TrackedObject* object, WorkingMap* map) {
    const ObjectEdit edit = map->Edit(object);
    EXPECT_EQ(edit.object().id(), object->id());
  }

  TrackedObject* Any(WorkingMap* map) {
    return map->AllObjects()[Integer(map->objects().size() - 1)];
  }

  /// Returns one of a few leaf origins, so that edits overlap.
  LeafOrigin Origin() {
    return {kLeafSide * static_cast<int>(Integer(2)), kLeafSide * static_cast<int>(Integer(1)), 0};
  }

  /// Returns one of a few positions on the world lattice, so that volumes overlap.
  Eigen::Vector3d Position() {
    return kScale.leaf_size_m() * Eigen::Vector3d(static_cast<double>(Integer(2)), 0.0, 0.0);
  }

  std::mt19937 random_;
};

/// Returns the snapshot that a map would publish if all its objects were marked as changed.
MapSnapshot WithAllObjects(const WorkingMap& map, const MapSnapshot& published) {
  MapSnapshot all = published;
  all.objects = {};
  for (const auto& [id, object] : map.objects()) all.objects.insert_or_assign(id, object.Publish());
  return all;
}

TEST(ObjectEdit, PutsEveryChangeIntoTheNextDelta) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    RandomEditor editor(seed);
    auto map = std::make_unique<WorkingMap>(MapConfig());
    MapSnapshot told;
    for (std::uint64_t frame = 1; frame <= 50; ++frame) {
      map->BeginFrame(Revision(frame), Timestamp::FromSeconds(0.1 * static_cast<double>(frame)));
      for (std::size_t steps = editor.Integer(6); steps > 0; --steps) editor.Step(map.get());
      map->EndFrame();
      if (editor.Integer(2) == 0) continue;
      const MapCommit commit = map->Commit();
      ASSERT_TRUE(Apply(commit.delta, &told).ok());
      ExpectSameMap(told, *commit.snapshot);
      ExpectSameMap(told, WithAllObjects(*map, *commit.snapshot));
      ASSERT_FALSE(HasFailure()) << "seed " << seed << ", frame " << frame;
      if (editor.Integer(5) > 0) continue;
      map = std::make_unique<WorkingMap>(MapConfig());
      map->Restore(told);
    }
  }
}

/// A map with one object, with all changes committed.
class ObjectEditTest : public ::testing::Test {
 protected:
  ObjectEditTest() {
    map_.BeginFrame(Revision(1), Timestamp::FromSeconds(1.0));
    object_ = &map_.AddObject(Eigen::Vector3d::Zero());
    {
      ObjectEdit edit = map_.Edit(object_);
      edit.StoreLeaf({0, 0, 0}, Leaf());
    }
    Finish();
    map_.BeginFrame(Revision(2), Timestamp::FromSeconds(2.0));
  }

  MapDelta Finish() {
    map_.EndFrame();
    return map_.Commit().delta;
  }

  /// Returns a leaf with surface.
  LeafVoxels Leaf() { return RandomLeaf(&random_, 1.0, /*smooth=*/true, /*color=*/false); }

  std::mt19937 random_{1};
  WorkingMap map_{MapConfig()};
  TrackedObject* object_ = nullptr;
};

TEST_F(ObjectEditTest, MarksNothingIfNothingIsChanged) {
  {
    const ObjectEdit edit = map_.Edit(object_);
    EXPECT_EQ(edit.object().state().status, ObjectStatus::kTentative);
  }
  const MapDelta delta = Finish();
  EXPECT_TRUE(delta.objects.empty());
  EXPECT_TRUE(delta.leaves.empty());
}

TEST_F(ObjectEditTest, MarksTheStateWithoutLeavesIfOnlyTheStateIsChanged) {
  {
    ObjectEdit edit = map_.Edit(object_);
    edit.state().status = ObjectStatus::kArchived;
    EXPECT_TRUE(map_.ArchivedObjects().empty()) << "before the edit ends";
  }
  EXPECT_EQ(map_.ArchivedObjects(), std::vector<TrackedObject*>{object_});
  const MapDelta delta = Finish();
  ASSERT_EQ(delta.objects.size(), 1U);
  EXPECT_EQ(delta.objects.front().state->revision, Revision(2));
  EXPECT_TRUE(delta.leaves.empty());
}

TEST_F(ObjectEditTest, UpdatesSurfaceAndPlaceAtItsEnd) {
  const Box far_leaf(Eigen::Vector3d(8.1, 0.1, 0.1), Eigen::Vector3d(8.3, 0.3, 0.3));
  ASSERT_TRUE(map_.ObjectsNear(far_leaf).empty());
  const std::size_t points = object_->surface().point_count();
  {
    ObjectEdit edit = map_.Edit(object_);
    edit.StoreLeaf({20 * kLeafSide, 0, 0}, Leaf());
    EXPECT_EQ(object_->surface().point_count(), points);
  }
  EXPECT_GT(object_->surface().point_count(), points);
  EXPECT_EQ(map_.ObjectsNear(far_leaf), std::vector<TrackedObject*>{object_});
  const MapDelta delta = Finish();
  EXPECT_EQ(delta.objects.size(), 1U);
  ASSERT_EQ(delta.leaves.size(), 1U);
  EXPECT_EQ(delta.leaves.front().key.origin, (LeafOrigin{20 * kLeafSide, 0, 0}));
}

TEST_F(ObjectEditTest, MarksTheLeavesThatAReplacedVolumeHad) {
  const TrackedObject empty(ObjectId(9), Eigen::Vector3d::Zero(), kScale);
  {
    ObjectEdit edit = map_.Edit(object_);
    edit.StoreLeaf({kLeafSide, 0, 0}, Leaf());
    edit.TakeVolume(empty);
  }
  EXPECT_EQ(object_->surface().point_count(), 0U);
  const MapDelta delta = Finish();
  ASSERT_EQ(delta.leaves.size(), 2U);
  for (const LeafChange& leaf : delta.leaves) EXPECT_TRUE(leaf.packed.empty());
}

TEST(ObjectEdit, ChangesAnObjectOutsideOfAMap) {
  TrackedObject object(ObjectId(1), Eigen::Vector3d::Zero(), kScale);
  std::mt19937 random(1);
  {
    ObjectEdit edit = ObjectEdit::OfUnregistered(&object);
    edit.state().class_id = ClassId(3);
    edit.StoreLeaf({0, 0, 0}, RandomLeaf(&random, 1.0, /*smooth=*/true, /*color=*/false));
  }
  EXPECT_EQ(object.state().class_id, ClassId(3));
  EXPECT_GT(object.surface().point_count(), 0U);
}

}  // namespace
}  // namespace steadymap

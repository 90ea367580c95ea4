// Boxes on a row along y: known ones, which frames of the session found or missed, and those that
// the session saw.

#include "core/objects/session_identity.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/change/surface_looks.h"
#include "core/objects/part_votes.h"
#include "core/types/map_config.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::Solid;
using ::steadymap::testing::StoreVolume;

const Eigen::Vector3d kSizeM(0.4, 0.5, 0.6);
const Eigen::Vector3d kOtherSizeM(0.4, 0.9, 0.3);

const Box kEverywhere(Eigen::Vector3d::Constant(-10.0), Eigen::Vector3d::Constant(10.0));

const Box kSupportSlab(Eigen::Vector3d(2.0, 0.0, 0.0), Eigen::Vector3d(4.0, 2.0, 0.3));
const Box kAboveSlab(Eigen::Vector3d(1.0, -1.0, 0.4), Eigen::Vector3d(5.0, 3.0, 1.6));
const Eigen::Vector3d kOnSlab(2.4, 0.4, 0.3);

// Of a box at y = 0.
const Box kFirstPart(Eigen::Vector3d(-10.0, -10.0, -10.0), Eigen::Vector3d(10.0, 0.2, 10.0));

class SessionIdentityTest : public ::testing::Test {
 protected:
  explicit SessionIdentityTest(const MapConfig& config = MapConfig()) : map_(config) {
    map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0));
  }

  TrackedObject* Put(ObjectStatus status,
                     const Eigen::Vector3d& place,
                     const Eigen::Vector3d& size) {
    TrackedObject& object = map_.AddObject(place);
    const Eigen::Vector3d low = place - object.state().T_world_object.position_world;
    ObjectEdit edit = map_.Edit(&object);
    StoreVolume(MakeVolume({Box(low, low + size)}, map_.scale()), &edit);
    ObjectState& state = edit.state();
    state.status = status;
    state.class_id = ClassId(7);
    state.belief = InitialBelief(0.6);
    state.supporting_frames = 20;
    return &object;
  }

  /// Adds a known box, all of whose surface has the given balance of looks; 0: was not looked at.
  TrackedObject* PutKnown(double y_m, int score, const Eigen::Vector3d& size = kSizeM) {
    TrackedObject* known = Put(ObjectStatus::kPresent, {2.0, y_m, 0.0}, size);
    if (score == 0) return known;
    ObjectEdit edit = map_.Edit(known);
    for (const SurfaceLeaf& leaf : known->surface().leaves()) {
      edit.state().evidence.MutableLeaf(leaf.origin).score.fill(static_cast<std::int8_t>(score));
    }
    return known;
  }

  /// Sets the balance of the looks at the surface of a known box within bounds.
  void SetScores(const Box& bounds_world, std::int8_t score, TrackedObject* known) {
    ObjectEdit edit = map_.Edit(known);
    const Eigen::Vector3d origin_world = known->state().T_world_object.position_world;
    for (const SurfaceLeaf& leaf : known->surface().leaves()) {
      LeafEvidence& evidence = edit.state().evidence.MutableLeaf(leaf.origin);
      for (const SurfaceVoxel& point : leaf.points) {
        if (!bounds_world.contains(origin_world + point.position_object.cast<double>())) continue;
        evidence.score[point.cell()] = score;
      }
    }
  }

  TrackedObject* PutSeen(double y_m, const Eigen::Vector3d& size = kSizeM) {
    return Put(ObjectStatus::kTentative, {2.0, y_m, 0.0}, size);
  }

  /// Adds a level surface, of which what is within its bounds was observed.
  TrackedObject* PutLevelSurface(ObjectStatus status, const Eigen::Vector2d& half_m) {
    const Eigen::Vector3d half(half_m.x(), half_m.y(), 0.15);
    return PutPlane(status, Eigen::Vector3d::UnitZ(), Box(-half, half));
  }

  /// Adds a plane through the origin, of which what is within bounds was observed.
  TrackedObject* PutPlane(ObjectStatus status, const Eigen::Vector3d& normal, const Box& bounds) {
    TrackedObject& object = map_.AddObject(Eigen::Vector3d::Zero());
    ObjectEdit edit = map_.Edit(&object);
    StoreVolume(testing::MakeVolume([&](const Eigen::Vector3d& point) { return normal.dot(point); },
                                    bounds,
                                    map_.scale(),
                                    [&](const Eigen::Vector3d& point) {
                                      return Grow(bounds, 1e-6).contains(point);
                                    }),
                &edit);
    edit.state().status = status;
    edit.state().class_id = ClassId(7);
    edit.state().belief = InitialBelief(0.6);
    edit.state().supporting_frames = 20;
    return &object;
  }

  /// Adds a level surface of the session.
  TrackedObject* PutSheet() { return PutLevelSurface(ObjectStatus::kTentative, {0.4, 0.4}); }

  /// Adds a known level surface of another class, `above_m` the surface of `PutSheet`.
  void PutKnownSheet(const Eigen::Vector2d& half_m, double above_m) {
    ObjectEdit edit = map_.Edit(PutLevelSurface(ObjectStatus::kPresent, half_m));
    edit.state().class_id = ClassId(8);
    edit.state().T_world_object.position_world.z() += above_m;
  }

  /// Adds a long level surface, turned about its middle.
  TrackedObject* PutStrip(ObjectStatus status, double yaw_rad) {
    TrackedObject* strip = PutLevelSurface(status, {0.6, 0.15});
    ObjectEdit edit = map_.Edit(strip);
    edit.state().T_world_object.yaw_rad = yaw_rad;
    return strip;
  }

  /// Adds boxes as one object without a label.
  TrackedObject* PutBoxes(ObjectStatus status, const std::vector<Box>& boxes) {
    TrackedObject* object = Put(status, boxes.front().min(), boxes.front().sizes());
    const Eigen::Vector3d origin_world = object->state().T_world_object.position_world;
    Solid bodies;
    for (const Box& box : boxes) {
      bodies.push_back(Box(box.min() - origin_world, box.max() - origin_world));
    }
    ObjectEdit edit = map_.Edit(object);
    edit.state().class_id = kNoClass;
    StoreVolume(MakeVolume(bodies, map_.scale()), &edit);
    return object;
  }

  /// Adds a large slab with a box on it, known as one object without a label, of which looks found
  /// all but the box if that is gone.
  TrackedObject* PutStructure(const Box& box, bool is_box_gone) {
    TrackedObject* known = PutBoxes(ObjectStatus::kPresent, {kSupportSlab, box});
    SetScores(kEverywhere, 2, known);
    const Eigen::Vector3d above_foot(0.0, 0.0, 0.15);
    if (is_box_gone) SetScores({box.min() + above_foot, box.max() * 1.1}, -2, known);
    return known;
  }

  /// Adds a box without a label.
  TrackedObject* PutUnlabelled(const Eigen::Vector3d& place, const Eigen::Vector3d& size = kSizeM) {
    TrackedObject* seen = Put(ObjectStatus::kTentative, place, size);
    ObjectEdit edit = map_.Edit(seen);
    edit.state().class_id = kNoClass;
    return seen;
  }

  /// Marks the space within bounds as seen through.
  void MarkFree(const Box& bounds_world) {
    const double step_m = 0.5 * map_.free_space().cell_size_m();
    const Eigen::Vector3i steps = (bounds_world.sizes() / step_m).cast<int>();
    for (int x = 0; x <= steps.x(); ++x) {
      for (int y = 0; y <= steps.y(); ++y) {
        const Eigen::Vector3d low = bounds_world.min() + step_m * Eigen::Vector3d(x, y, 0.0);
        map_.MarkFree(low, {low.x(), low.y(), bounds_world.max().z()}, map_.now());
      }
    }
  }

  /// Marks the space beside a box and above it as seen through.
  void MarkFreeAround(const Box& box_world) {
    const Eigen::Vector3d gap = Eigen::Vector3d::Constant(map_.scale().voxel_size_m);
    const Box inner(box_world.min() - gap, box_world.max() + gap);
    const Box outer = Grow(box_world, 0.3);
    for (int axis = 0; axis < 3; ++axis) {
      Box before = outer;
      before.max()[axis] = inner.min()[axis];
      Box after = outer;
      after.min()[axis] = inner.max()[axis];
      if (axis < 2) MarkFree(before);
      MarkFree(after);
    }
  }

  std::vector<ObjectEvent> Decide() {
    DecideSession(MapConfig(), SessionIdentityParameters(), {}, &map_);
    map_.EndFrame();
    for (const auto& [id, object] : map_.objects()) {
      EXPECT_NE(object.state().status, ObjectStatus::kTentative);
      EXPECT_TRUE(object.state().evidence.leaves.empty());
      EXPECT_TRUE(object.state().parts.empty());
    }
    return map_.Commit().delta.events;
  }

  void SetSource(const SensorName& source, TrackedObject* object) {
    ObjectEdit edit = map_.Edit(object);
    edit.state().source = source;
  }

  WorkingMap map_;
};

MapConfig TwoCentimetreConfig() {
  MapConfig config;
  config.voxel_size_m = 0.02;
  config.truncation_m = 0.06;
  return config;
}

/// A map with voxels of 2 cm.
class FineSessionIdentityTest : public SessionIdentityTest {
 protected:
  FineSessionIdentityTest() : SessionIdentityTest(TwoCentimetreConfig()) {}
};

class CoarseSessionIdentityTest : public SessionIdentityTest {
 protected:
  CoarseSessionIdentityTest() : SessionIdentityTest({.voxel_size_m = 0.1, .truncation_m = 0.3}) {}

  /// Adds the voxels around a point of the surface of a plane.
  TrackedObject* PutPatch(int voxels) {
    TrackedObject* seen = PutSeen(0.0);
    LeafVoxels leaf;
    for (int y = 0; y < voxels; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const std::size_t offset = OffsetInLeaf(4 + x, y, 4);
        leaf.voxels[offset] = testing::VoxelWithDistance(-0.1 * x, map_.scale());
        SetBit(offset, &leaf.observed);
      }
    }
    TsdfGrid volume;
    volume.StoreLeaf({0, 0, 0}, leaf);
    ObjectEdit edit = map_.Edit(seen);
    StoreVolume(volume, &edit);
    return seen;
  }
};

void ExpectTwoMoves(const std::vector<ObjectEvent>& events) {
  EXPECT_EQ(events.size(), 2U);
  for (const ObjectEvent& event : events) EXPECT_EQ(event.type, EventType::kMoved);
}

TEST_F(SessionIdentityTest, WhatNoKnownObjectExplainsIsNew) {
  PutKnown(0.0, 2);
  const ObjectId seen = PutSeen(2.0, kOtherSizeM)->id();
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kCreated);
  EXPECT_EQ(events.front().object, seen);
}

TEST_F(SessionIdentityTest, ASmallObjectBesideALargeOneOfItsClassIsAFragment) {
  TrackedObject* large = PutSeen(0.0, {2.0, 2.0, 1.0});
  TrackedObject* small = PutSeen(2.2, {0.2, 0.2, 0.2});
  EXPECT_TRUE(IsFragmentOf(*small, *large, SessionPartParameters()));
  EXPECT_FALSE(IsFragmentOf(*large, *small, SessionPartParameters()));
  // Without labels, everything is of one class.
  for (TrackedObject* object : {large, small}) {
    ObjectEdit edit = map_.Edit(object);
    edit.state().class_id = kNoClass;
  }
  EXPECT_FALSE(IsFragmentOf(*small, *large, SessionPartParameters()));
}

TEST_F(SessionIdentityTest, WithoutALabelASurfaceCountsWithItsWeight) {
  TrackedObject* seen = PutSeen(0.0, {0.3, 0.3, 0.3});
  const auto is_too_small = [&](ClassId class_id, float weight) {
    {
      ObjectEdit edit = map_.Edit(seen);
      edit.state().class_id = class_id;
      StoreVolume(testing::WithWeight(seen->volume(), weight), &edit);
    }
    return IsTooSmall(*seen, SessionPartParameters());
  };
  EXPECT_FALSE(is_too_small(ClassId(7), 0.1F));
  EXPECT_TRUE(is_too_small(kNoClass, 0.1F));
  EXPECT_FALSE(is_too_small(kNoClass, 1.0F));
}

TEST_F(SessionIdentityTest, AnObjectInPlaceIsConfirmedWithoutAnEvent) {
  const TrackedObject* known = PutKnown(0.0, 2);
  const double before = known->state().belief.stationarity();
  PutSeen(0.0);
  EXPECT_TRUE(Decide().empty());
  ASSERT_EQ(map_.objects().size(), 1U);
  EXPECT_EQ(known->state().supporting_frames, 40U);
  EXPECT_GT(known->state().belief.stationarity(), before);
  EXPECT_GT(known->state().evidence.present_cells, 0.0);
  EXPECT_EQ(known->state().evidence.absent_cells, 0.0);
}

TEST_F(SessionIdentityTest, AThingThatMovesOnAStructureWithoutLabelsHasMoved) {
  MarkFree(kAboveSlab);
  const TrackedObject* structure = PutStructure({kOnSlab, kOnSlab + kSizeM}, true);
  PutUnlabelled({3.2, 1.2, 0.3});
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kMoved);
  EXPECT_NE(events.front().object, structure->id());
  EXPECT_LT((events.front().center_world - Eigen::Vector3d(3.4, 1.45, 0.6)).norm(), 0.1);
  EXPECT_EQ(structure->state().status, ObjectStatus::kPresent);
  EXPECT_EQ(structure->state().last_seen, Timestamp::FromSeconds(100.0));
  EXPECT_LT(structure->BoundsInWorld().max().z(), 0.5);
}

TEST_F(SessionIdentityTest, AStructureOfWhichNothingIsGoneStays) {
  MarkFree(kAboveSlab);
  const TrackedObject* structure = PutStructure({kOnSlab, kOnSlab + kSizeM}, false);
  EXPECT_TRUE(Decide().empty());
  EXPECT_NEAR(structure->BoundsInWorld().max().z(), 0.9, 0.1);
}

TEST_F(SessionIdentityTest, AnObjectThatWasNotLookedAtStays) {
  PutKnown(0.0, 0);
  EXPECT_TRUE(Decide().empty());
}

TEST_F(SessionIdentityTest, AnObjectKeepsTheSumsOfTheSessionThatLastLookedAtIt) {
  TrackedObject* known = PutKnown(0.0, 2);
  Decide();
  const double present = known->state().evidence.present_cells;
  Decide();
  EXPECT_EQ(known->state().evidence.present_cells, present);
}

TEST_F(SessionIdentityTest, AnObjectThatLooksMissIsRemovedAndKeptAsHistory) {
  const TrackedObject* gone = PutKnown(0.0, -2);
  PutKnown(2.0, 2);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kRemoved);
  EXPECT_EQ(events.front().object, gone->id());
  EXPECT_LT(events.front().after.stationarity(), events.front().before.stationarity());
  EXPECT_TRUE(gone->is_history());
  EXPECT_EQ(gone->state().evidence.present_cells, 0.0);
  EXPECT_GT(gone->state().evidence.absent_cells, 0.0);
}

// Where the old and the new place of a strip cross, both agree; the rest of each is not known to
// the other one.
TEST_F(SessionIdentityTest, AFlatThingThatWasTurnedHasMoved) {
  TrackedObject* strip = PutStrip(ObjectStatus::kPresent, 0.0);
  SetScores(kEverywhere, -2, strip);
  const Eigen::Vector3d center_world = strip->BoundsInWorld().center();
  const Eigen::Vector3d reach_m = Eigen::Vector3d::Constant(0.2);
  SetScores({center_world - reach_m, center_world + reach_m}, 2, strip);
  PutStrip(ObjectStatus::kTentative, M_PI / 3.0);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kMoved);
  EXPECT_EQ(events[0].object, strip->id());
}

TEST_F(SessionIdentityTest, AShapeThatLeftOnePlaceForAnotherHasMoved) {
  const TrackedObject* moved = PutKnown(0.0, -2);
  PutKnown(2.0, -2, kOtherSizeM);
  PutSeen(5.0);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].type, EventType::kMoved);
  EXPECT_EQ(events[0].object, moved->id());
  EXPECT_NEAR((events[0].center_world - *events[0].old_center_world).y(), 5.0, 0.03);
  EXPECT_EQ(events[1].type, EventType::kRemoved);
}

TEST_F(SessionIdentityTest, AThingOfWhichOneSideIsSeenElsewhereHasMoved) {
  const TrackedObject* moved = PutKnown(0.0, -2);
  PutKnown(2.0, -2, kOtherSizeM);
  const Eigen::Vector3d half(0.15, 0.5 * kSizeM.y(), 0.5 * kSizeM.z());
  TrackedObject* side =
      PutPlane(ObjectStatus::kTentative, -Eigen::Vector3d::UnitX(), Box(-half, half));
  ASSERT_LT(side->SurfaceAreaM2(), 0.3 * moved->SurfaceAreaM2());
  {
    ObjectEdit edit = map_.Edit(side);
    edit.state().T_world_object.position_world = {5.0, 0.0, 0.3};
  }
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].type, EventType::kMoved);
  EXPECT_EQ(events[0].object, moved->id());
  EXPECT_NEAR(events[0].center_world.x(), 5.0 + 0.5 * kSizeM.x(), 0.03);
  EXPECT_EQ(events[1].type, EventType::kRemoved);
}

TEST_F(SessionIdentityTest, APushOfTenCentimetresIsAMove) {
  PutKnown(0.0, 2);
  PutKnown(2.0, 2, kOtherSizeM);
  PutSeen(0.1);
  PutSeen(2.0, kOtherSizeM);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kMoved);
  EXPECT_NEAR((events.front().center_world - *events.front().old_center_world).norm(), 0.1, 0.02);
}

TEST_F(SessionIdentityTest, AThingThatSlidAlongItsPlaneHasMoved) {
  // What is found of it is the surface of the same thing at its new place.
  TrackedObject* known = PutKnown(0.0, 2);
  SetScores(kFirstPart, -2, known);
  PutKnown(2.0, 2, kOtherSizeM);
  PutSeen(0.2);
  PutSeen(2.0, kOtherSizeM);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kMoved);
  EXPECT_EQ(events.front().object, known->id());
  EXPECT_NEAR((events.front().center_world - *events.front().old_center_world).y(), 0.2, 0.03);
}

TEST_F(SessionIdentityTest, AThingSeenFromItsOtherSideHasNotMoved) {
  const Eigen::Vector3d low(-0.2, -0.25, 0.0);
  const Eigen::Vector3d high(0.2, 0.25, 0.6);
  const auto put_half = [&](ObjectStatus status, double side) {
    TrackedObject* half = Put(status, {2.0, 0.0, 0.0}, high - low);
    ObjectEdit edit = map_.Edit(half);
    StoreVolume(MakeVolume(
                    [&](const Eigen::Vector3d& point) {
                      return testing::DistanceFrom({Box(low, high)}, point);
                    },
                    Grow(Box(low, high), map_.scale().truncation_m),
                    map_.scale(),
                    [&](const Eigen::Vector3d& point) {
                      return side * point.y() > -0.05 && point.z() >= 0.0;
                    }),
                &edit);
    edit.state().T_world_object.position_world = {2.0, 0.0, 0.0};
    return half;
  };
  TrackedObject* known = put_half(ObjectStatus::kPresent, 1.0);
  SetScores(kEverywhere, 2, known);
  put_half(ObjectStatus::kTentative, -1.0);
  EXPECT_TRUE(Decide().empty());
  ASSERT_EQ(map_.objects().size(), 1U);
  EXPECT_NEAR(known->cuboid().size_m.head<2>().maxCoeff(), 0.5, 0.05);
}

TEST_F(SessionIdentityTest, ATurnInPlaceIsAMoveAlthoughNoLookMissesTheThing) {
  const auto put = [this](ObjectStatus status, double yaw_rad) {
    TrackedObject* object = Put(status, {2.0, 0.0, 0.0}, {0.3, 0.5, 0.6});
    ObjectEdit edit = map_.Edit(object);
    StoreVolume(
        MakeVolume({Box(Eigen::Vector3d(-0.15, -0.25, 0.0), Eigen::Vector3d(0.15, 0.25, 0.6))},
                   map_.scale()),
        &edit);
    edit.state().T_world_object.yaw_rad = yaw_rad;
    return object;
  };
  TrackedObject* known = put(ObjectStatus::kPresent, 0.0);
  SetScores(kEverywhere, 2, known);
  put(ObjectStatus::kTentative, 0.8);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kMoved);
  EXPECT_EQ(events.front().object, known->id());
  EXPECT_LT((events.front().center_world - *events.front().old_center_world).norm(), 0.03);
}

TEST_F(SessionIdentityTest, APartThatIsGoneIsNoMove) {
  TrackedObject* known = PutKnown(0.0, 2);
  SetScores(kFirstPart, -2, known);
  Put(ObjectStatus::kTentative, {2.0, 0.2, 0.0}, {0.4, 0.3, 0.6});
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kRemoved);
  EXPECT_LT(events[0].center_world.y(), 0.2);
  EXPECT_EQ(known->state().status, ObjectStatus::kPresent);
}

TEST_F(SessionIdentityTest, AThingInFrontOfAHiddenOneIsNew) {
  TrackedObject* hidden = PutKnown(0.0, 0, {0.1, 0.5, 0.6});
  // All that was seen of it is the side that is hidden now; the ends of both are in one plane.
  SetScores(kEverywhere, 2, hidden);
  const TrackedObject* seen = Put(ObjectStatus::kTentative, {1.5, 0.0, 0.0}, {0.45, 0.5, 0.6});
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kCreated);
  EXPECT_EQ(events.front().object, seen->id());
  EXPECT_EQ(map_.objects().size(), 2U);
}

TEST_F(SessionIdentityTest, AThingPushedInFrontOfItsOldPlaceHasMoved) {
  // What was found of it is where the sides of both are in one plane.
  TrackedObject* known = PutKnown(0.0, 0);
  SetScores(Box(Eigen::Vector3d(2.02, -1.0, -1.0), Eigen::Vector3d(2.1, 1.0, 1.0)), 2, known);
  Put(ObjectStatus::kTentative, {1.7, 0.0, 0.0}, kSizeM);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kMoved);
  EXPECT_EQ(events.front().object, known->id());
  EXPECT_NEAR((events.front().center_world - *events.front().old_center_world).x(), -0.3, 0.03);
}

TEST_F(SessionIdentityTest, ALargerThingInThePlaceOfAKnownOneReplacesIt) {
  // The looks found the surface of the larger one near that of the known one. Nobody sees the
  // bottoms, so that these must not coincide.
  TrackedObject* known = Put(ObjectStatus::kPresent, {2.1, 0.0, 0.1}, {0.4, 0.34, 0.28});
  SetScores(kEverywhere, 2, known);
  const TrackedObject* seen = Put(ObjectStatus::kTentative, {2.0, 0.06, 0.0}, {0.6, 0.22, 0.56});
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(map_.objects().at(known->id()).state().status, ObjectStatus::kArchived);
  EXPECT_EQ(map_.objects().at(seen->id()).state().status, ObjectStatus::kPresent);
}

TEST_F(SessionIdentityTest, AThingThatCameDownHasMoved) {
  // The sides of both places are in one plane.
  TrackedObject* known = Put(ObjectStatus::kPresent, {2.0, 0.0, 0.4}, {0.3, 0.25, 0.3});
  SetScores(kEverywhere, -2, known);
  Put(ObjectStatus::kTentative, {2.0, 0.0, 0.15}, {0.3, 0.25, 0.3});
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kMoved);
  EXPECT_EQ(events.front().object, known->id());
  EXPECT_NEAR((events.front().center_world - *events.front().old_center_world).z(), -0.25, 0.03);
}

TEST_F(SessionIdentityTest, AMugOnATableWithoutLabelsIsNew) {
  const Box table(Eigen::Vector3d(2.0, 0.0, 0.0), Eigen::Vector3d(2.8, 1.0, 0.3));
  const Box mug(Eigen::Vector3d(2.4, 0.4, 0.3), Eigen::Vector3d(2.55, 0.55, 0.5));
  const TrackedObject* known = PutBoxes(ObjectStatus::kPresent, {table});
  PutBoxes(ObjectStatus::kTentative, {table, mug});
  MarkFreeAround(mug);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kCreated);
  EXPECT_NE(events.front().object, known->id());
  EXPECT_LT((events.front().center_world - mug.center()).norm(), 0.1);
  EXPECT_NEAR(known->BoundsInWorld().max().z(), 0.3, 0.03);
}

TEST_F(SessionIdentityTest, AFewPointsOfAnUnlabelledThingLeaveTheRestToIt) {
  TrackedObject* known = PutUnlabelled({2.0, 0.0, 0.0});
  {
    ObjectEdit edit = map_.Edit(known);
    edit.state().status = ObjectStatus::kPresent;
  }
  TrackedObject* piece = Put(ObjectStatus::kTentative, {2.0, 0.0, 0.0}, {0.4, 0.02, 0.1});
  {
    ObjectEdit edit = map_.Edit(piece);
    edit.state().class_id = kNoClass;
    edit.state().has_given_extent = true;
  }
  PutUnlabelled({2.0, 0.0, 0.0});
  EXPECT_TRUE(Decide().empty());
}

TEST_F(SessionIdentityTest, TheFrontOfAThingIsNoFragmentOfItsNeighbour) {
  PutSeen(0.0);
  PutSeen(0.8, {0.03, 0.5, 0.6});
  EXPECT_EQ(Decide().size(), 2U);
}

TEST_F(SessionIdentityTest, ADisplacementThatAllThingsShareIsThatOfTheRobot) {
  PutKnown(0.0, 2);
  PutKnown(2.0, 2, kOtherSizeM);
  PutKnown(4.0, 2, {0.6, 0.6, 0.6});
  PutSeen(0.07);
  PutSeen(2.07, kOtherSizeM);
  PutSeen(4.07, {0.6, 0.6, 0.6});
  EXPECT_TRUE(Decide().empty());
  EXPECT_EQ(map_.objects().size(), 3U);
}

TEST_F(SessionIdentityTest, TwinsAreNotGuessed) {
  PutKnown(0.0, -2);
  PutKnown(2.0, -2);
  PutSeen(5.0);
  for (const ObjectEvent& event : Decide()) EXPECT_NE(event.type, EventType::kMoved);
}

TEST_F(SessionIdentityTest, TwinsThatWereBothPushedAreToldApartByTheirPlaces) {
  const TrackedObject* one = PutKnown(0.0, -2);
  const TrackedObject* other = PutKnown(2.0, -2);
  PutSeen(0.25);
  PutSeen(2.25);
  ExpectTwoMoves(Decide());
  EXPECT_NEAR(other->cuboid().center_world.y() - one->cuboid().center_world.y(), 2.0, 0.05);
}

TEST_F(SessionIdentityTest, TwoUnlikeShapesThatChangedPlacesHaveBothMoved) {
  // Each is in the place of the other one, where it may have been pushed.
  const Eigen::Vector3d low_size_m(0.5, 0.35, 0.45);
  const Eigen::Vector3d tall_size_m(0.35, 0.3, 0.6);
  const TrackedObject* low = PutKnown(0.0, -2, low_size_m);
  const TrackedObject* tall = PutKnown(2.0, -2, tall_size_m);
  PutSeen(0.0, tall_size_m);
  PutSeen(2.0, low_size_m);
  ExpectTwoMoves(Decide());
  EXPECT_NEAR(low->cuboid().size_m.z(), low_size_m.z(), 0.05);
  EXPECT_NEAR(low->cuboid().center_world.y(), 2.175, 0.05);
  EXPECT_NEAR(tall->cuboid().size_m.z(), tall_size_m.z(), 0.05);
  EXPECT_NEAR(tall->cuboid().center_world.y(), 0.15, 0.05);
}

TEST_F(SessionIdentityTest, AShapeThatBothObjectsHaveElsewhereIsNoPush) {
  // Of two unlike boxes that changed places, each was close to where the other one is now.
  const Eigen::Vector3d long_size_m(0.4, 0.6, 0.5);
  const Eigen::Vector3d short_size_m(0.4, 0.48, 0.5);
  const TrackedObject* one = PutKnown(0.0, -2, long_size_m);
  const TrackedObject* other = PutKnown(2.0, -2, short_size_m);
  PutSeen(0.1, short_size_m);
  PutSeen(2.1, long_size_m);
  ExpectTwoMoves(Decide());
  EXPECT_NEAR(one->cuboid().center_world.y(), 2.4, 0.05);
  EXPECT_NEAR(other->cuboid().center_world.y(), 0.325, 0.05);
}

TEST_F(SessionIdentityTest, AThingWhosePlaceAnotherOneTookHasMoved) {
  // Of a box, looks found the sides that it has in common with the larger one in its place.
  const Eigen::Vector3d large_size_m(0.6, 0.7, 0.9);
  const TrackedObject* small = PutKnown(0.0, 2);
  const TrackedObject* large = PutKnown(3.0, -2, large_size_m);
  PutSeen(-0.1, large_size_m);
  PutSeen(6.0);
  ExpectTwoMoves(Decide());
  EXPECT_NEAR(small->cuboid().center_world.y(), 6.25, 0.05);
  EXPECT_NEAR(large->cuboid().center_world.y(), 0.25, 0.05);
}

TEST_F(SessionIdentityTest, ASmallThingIsGoneIfTheHalfOfItThatFacesTheCameraIs) {
  TrackedObject* const mug =
      Put(ObjectStatus::kPresent, {2.01, 0.01, 0.0}, Eigen::Vector3d(0.05, 0.05, 0.1));
  SetScores(Box(Eigen::Vector3d(-10.0, -10.0, 0.06), Eigen::Vector3d(10.0, 10.0, 10.0)), -2, mug);
  const LookCount looks = CountLooks(*mug);
  ASSERT_GT(looks.gone, 0U);
  ASSERT_LT(looks.gone, SessionIdentityParameters().parts.min_points);
  ASSERT_LT(looks.gone, looks.cells);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kRemoved);
}

TEST_F(SessionIdentityTest, ARemovedObjectBackInItsPlaceReturns) {
  TrackedObject* removed = PutKnown(0.0, 0);
  {
    ObjectEdit edit = map_.Edit(removed);
    edit.state().status = ObjectStatus::kArchived;
  }
  PutSeen(0.0);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kReturned);
  EXPECT_EQ(events.front().object, removed->id());
}

TEST_F(SessionIdentityTest, ARemovedObjectOfWhichMoreIsSeenReturnsToItsPlace) {
  TrackedObject* removed = PutKnown(0.0, 0, {0.4, 1.0, 0.6});
  {
    ObjectEdit edit = map_.Edit(removed);
    edit.state().status = ObjectStatus::kArchived;
  }
  PutSeen(0.0, {0.4, 2.4, 0.6});
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().type, EventType::kReturned);
  EXPECT_EQ(events.front().object, removed->id());
}

TEST_F(SessionIdentityTest, WhatCameAndWentInOneSessionIsToldTwice) {
  TrackedObject* seen = PutSeen(0.0);
  {
    ObjectEdit edit = map_.Edit(seen);
    for (const SurfaceLeaf& leaf : seen->surface().leaves()) {
      edit.state().evidence.MutableLeaf(leaf.origin).score.fill(-2);
    }
  }
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].type, EventType::kCreated);
  EXPECT_EQ(events[1].type, EventType::kRemoved);
}

TEST_F(SessionIdentityTest, PartsThatFramesConnectAreOneObject) {
  TrackedObject* one = PutSeen(0.0);
  TrackedObject* other = PutSeen(0.7);
  VoteOnParts(PartVote::kConnected, one, other, &map_);
  EXPECT_EQ(Decide().size(), 1U);
  EXPECT_EQ(map_.objects().size(), 1U);
}

TEST_F(SessionIdentityTest, WhatAThingHidesOfItsInsideIsAPartOfIt) {
  TrackedObject* crate = PutSeen(0.0, kOtherSizeM);
  TrackedObject* inside = Put(ObjectStatus::kTentative, {2.1, 0.3, 0.1}, {0.1, 0.3, 0.1});
  for (int i = 0; i < 20; ++i) VoteOnParts(PartVote::kOccluded, crate, inside, &map_);
  EXPECT_EQ(Decide().size(), 1U);
}

TEST_F(SessionIdentityTest, WhatHasItsOwnInstanceInsideAThingIsNoPartOfIt) {
  TrackedObject* crate = PutSeen(0.0, kOtherSizeM);
  TrackedObject* inside = Put(ObjectStatus::kTentative, {2.1, 0.3, 0.1}, {0.1, 0.3, 0.1});
  for (int i = 0; i < 20; ++i) VoteOnParts(PartVote::kOccluded, crate, inside, &map_);
  for (int i = 0; i < 3; ++i) VoteOnParts(PartVote::kApart, crate, inside, &map_);
  EXPECT_EQ(Decide().size(), 2U);
}

TEST_F(SessionIdentityTest, MostFramesOfTheJoinedPartsChooseTheirClass) {
  TrackedObject* edge = PutSeen(0.0);
  TrackedObject* rest = PutSeen(0.7);
  VoteOnParts(PartVote::kConnected, edge, rest, &map_);
  {
    ObjectEdit edit = map_.Edit(edge);
    edit.state().class_id = ClassId(4);
    edit.state().votes = {{ClassId(4), 3.0}, {ClassId(7), 2.0}};
  }
  {
    ObjectEdit edit = map_.Edit(rest);
    edit.state().votes = {{ClassId(7), 40.0}};
  }
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.front().class_id, ClassId(7));
}

TEST_F(SessionIdentityTest, APieceInContactWithAnObjectThatWasNotLookedAtIsAPartOfIt) {
  TrackedObject* known = PutKnown(0.0, 0);
  PutSeen(0.5, kOtherSizeM);
  EXPECT_TRUE(Decide().empty());
  EXPECT_EQ(map_.objects().size(), 1U);
  EXPECT_GT(known->cuboid().size_m.maxCoeff(), 1.2);
}

TEST_F(SessionIdentityTest, APieceInContactWithAnObjectThatIsGoneIsNew) {
  PutKnown(0.0, -2);
  PutSeen(0.5, {1.5, 1.5, 1.2});
  EXPECT_EQ(Decide().size(), 2U);
}

TEST_F(SessionIdentityTest, ObjectsThatFramesShowApartAreTwoEvenInContact) {
  TrackedObject* one = PutSeen(0.0);
  TrackedObject* other = PutSeen(0.5);
  VoteOnParts(PartVote::kConnected, one, other, &map_);
  for (int i = 0; i < 10; ++i) VoteOnParts(PartVote::kApart, one, other, &map_);
  EXPECT_EQ(Decide().size(), 2U);
  EXPECT_EQ(map_.objects().size(), 2U);
}

TEST_F(SessionIdentityTest, AWrongLabelOnAnObjectIsNoObjectThoughFramesShowBothApart) {
  TrackedObject* whole = PutSeen(0.0);
  TrackedObject* patch = PutSeen(0.0, {0.4, 0.4, 0.6});
  {
    ObjectEdit edit = map_.Edit(patch);
    edit.state().class_id = ClassId(9);
  }
  VoteOnParts(PartVote::kApart, whole, patch, &map_);
  EXPECT_EQ(Decide().size(), 1U);
  EXPECT_EQ(map_.objects().size(), 1U);
}

TEST_F(SessionIdentityTest, TwoObjectsDoNotHaveOneSurfaceThoughFramesShowBothApart) {
  TrackedObject* whole = PutSeen(0.0);
  TrackedObject* layer = PutSeen(0.0, {0.4, 0.4, 0.6});
  for (int i = 0; i < 10; ++i) VoteOnParts(PartVote::kApart, whole, layer, &map_);
  EXPECT_EQ(Decide().size(), 1U);
  EXPECT_EQ(map_.objects().size(), 1U);
}

TEST_F(SessionIdentityTest, PartsWithNothingSeenBetweenThemAreOneObject) {
  PutSeen(0.0);
  PutSeen(0.7);
  EXPECT_EQ(Decide().size(), 1U);
}

TEST_F(SessionIdentityTest, AThingSeenAndThenFoundGoneCameAndLeft) {
  SetScores(kEverywhere, -2, PutSheet());
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].type, EventType::kCreated);
  EXPECT_EQ(events[1].type, EventType::kRemoved);
}

TEST_F(SessionIdentityTest, AKnownThingThatLeavesInViewIsRemoved) {
  const TrackedObject* known = PutKnown(0.0, -2);
  SetScores(kEverywhere, -2, PutSeen(0.0));
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kRemoved);
  EXPECT_EQ(events[0].object, known->id());
}

TEST_F(SessionIdentityTest, AThingWithoutALabelThatLeavesInViewIsRemoved) {
  MarkFree(kAboveSlab);
  PutStructure({kOnSlab, kOnSlab + kSizeM}, false);
  TrackedObject* known = PutUnlabelled({3.2, 1.2, 0.3});
  {
    ObjectEdit edit = map_.Edit(known);
    edit.state().status = ObjectStatus::kPresent;
  }
  SetScores(kEverywhere, -2, known);
  SetScores(kEverywhere, -2, PutUnlabelled({3.2, 1.2, 0.3}));
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kRemoved);
  EXPECT_EQ(events[0].object, known->id());
}

TEST_F(SessionIdentityTest, AKnownThingThatIsGoneWhenItsOtherSidesAreSeenIsRemoved) {
  TrackedObject* known = PutKnown(0.0, -2);
  {
    ObjectEdit edit = map_.Edit(known);
    for (LeafEvidence& leaf : edit.state().evidence.leaves) leaf.last_look = map_.now();
  }
  TrackedObject* seen = PutSeen(0.0);
  {
    ObjectEdit edit = map_.Edit(seen);
    edit.state().last_seen = map_.now() - Duration::FromSeconds(5.0);
  }
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kRemoved);
  EXPECT_EQ(events[0].object, known->id());
  EXPECT_EQ(map_.objects().size(), 1U);
}

TEST_F(SessionIdentityTest, AThingThatLeavesInViewForAnotherPlaceHasMoved) {
  const TrackedObject* known = PutKnown(0.0, -2);
  SetScores(kEverywhere, -2, PutSeen(0.0));
  PutSeen(3.0);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kMoved);
  EXPECT_EQ(events[0].object, known->id());
}

TEST_F(SessionIdentityTest, OneOfTwoNeighboursThatWereOneObjectIsRemoved) {
  TrackedObject* pair = PutKnown(0.0, 2, {0.8, 0.4, 0.5});
  const Box gone(Eigen::Vector3d(2.45, -0.1, -0.1), Eigen::Vector3d(3.0, 0.5, 0.6));
  SetScores(gone, -2, pair);
  PutSeen(0.0, {0.4, 0.4, 0.5});
  MarkFree(Box(Eigen::Vector3d(2.5, -0.2, 0.0), Eigen::Vector3d(3.2, 0.6, 0.8)));
  MarkFree(Box(Eigen::Vector3d(1.3, -0.2, 0.0), Eigen::Vector3d(1.9, 0.6, 0.8)));
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kRemoved);
  EXPECT_NE(events[0].object, pair->id());
  EXPECT_EQ(events[0].related, pair->id());
  EXPECT_GT(events[0].center_world.x(), 2.45);
  EXPECT_EQ(pair->state().status, ObjectStatus::kPresent);
  EXPECT_LT(pair->cuboid().center_world.x(), 2.35);
}

TEST_F(SessionIdentityTest, WhatHasTheSurfaceOfTheBackgroundAndIsGoneWasAWrongLabel) {
  TrackedObject* sheet = PutSheet();
  SetScores(kEverywhere, -2, sheet);
  sheet->volume().VisitLeaves([&](LeafOrigin origin, const LeafView& leaf) {
    LeafVoxels voxels;
    CopyLeaf(leaf, &voxels);
    map_.StoreBackgroundLeaf(origin, voxels);
    return true;
  });
  EXPECT_TRUE(Decide().empty());
}

constexpr double kWithinNoiseM = 0.06;

TEST_F(SessionIdentityTest, WhatHasMostOfTheSurfaceOfAnotherClassAndIsGoneWasAWrongLabel) {
  SetScores(kEverywhere, -2, PutSheet());
  PutKnownSheet({0.4, 0.4}, kWithinNoiseM);
  EXPECT_TRUE(Decide().empty());
}

TEST_F(SessionIdentityTest, WhatHasHalfOfItsSurfaceInCommonWithAnotherClassWasAWrongLabel) {
  SetScores(kEverywhere, -2, PutSheet());
  PutKnownSheet({0.4, 0.25}, 0.0);
  EXPECT_TRUE(Decide().empty());
}

TEST_F(SessionIdentityTest, AThingOfWhichHalfIsNearAnotherClassCameAndLeft) {
  SetScores(kEverywhere, -2, PutSheet());
  PutKnownSheet({0.4, 0.25}, kWithinNoiseM);
  const std::vector<ObjectEvent> events = Decide();
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].type, EventType::kCreated);
  EXPECT_EQ(events[1].type, EventType::kRemoved);
}

TEST_F(SessionIdentityTest, ThingsWithFreeSpaceBetweenThemAreTwoObjects) {
  PutSeen(0.0);
  PutSeen(0.7);
  MarkFree(Box(Eigen::Vector3d(1.9, 0.5, 0.0), Eigen::Vector3d(2.6, 0.7, 0.8)));
  EXPECT_EQ(Decide().size(), 2U);
}

TEST_F(SessionIdentityTest, ThingsFarFromEachOtherAreTwoObjects) {
  PutSeen(0.0);
  PutSeen(0.9);
  EXPECT_EQ(Decide().size(), 2U);
}

TEST_F(SessionIdentityTest, APartInsideAnObjectOfItsClassBelongsToIt) {
  PutSeen(0.0, {0.4, 1.2, 0.9});
  Put(ObjectStatus::kTentative, {2.12, 0.3, 0.12}, {0.16, 0.6, 0.66});
  EXPECT_EQ(Decide().size(), 1U);
}

const Eigen::Vector3d kPostSizeM(0.06, 0.06, 1.2);

TEST_F(SessionIdentityTest, APostBesideAThingOfItsClassIsAPartOfIt) {
  PutSeen(0.0);
  PutSeen(0.8, kPostSizeM);
  EXPECT_EQ(Decide().size(), 1U);
  EXPECT_EQ(map_.objects().size(), 1U);
}

TEST_F(SessionIdentityTest, APostThatWasSeenFromEndToEndIsAnObject) {
  PutSeen(0.0);
  PutSeen(0.8, kPostSizeM);
  MarkFree(Box(Eigen::Vector3d(1.7, 0.55, -0.5), Eigen::Vector3d(2.3, 1.1, -0.02)));
  MarkFree(Box(Eigen::Vector3d(1.7, 0.55, 1.22), Eigen::Vector3d(2.3, 1.1, 1.6)));
  EXPECT_EQ(Decide().size(), 2U);
}

TEST_F(SessionIdentityTest, APostFarFromAThingOfItsClassIsAnObject) {
  PutSeen(0.0);
  PutSeen(1.6, kPostSizeM);
  EXPECT_EQ(Decide().size(), 2U);
}

TEST_F(SessionIdentityTest, ObjectsOfOtherSessionsWaitForTheirOwnEnd) {
  const SensorName one{"one", "left"};
  const SensorName other{"one", "right"};
  TrackedObject* seen = PutSeen(0.0);
  SetSource(one, seen);
  TrackedObject* waiting = PutSeen(0.0, kOtherSizeM);
  SetSource(other, waiting);
  SetScores(kEverywhere, 2, waiting);
  DecideSession(MapConfig(), SessionIdentityParameters(), one, &map_);
  EXPECT_EQ(seen->state().status, ObjectStatus::kPresent);
  EXPECT_EQ(seen->state().source, one);
  EXPECT_EQ(waiting->state().status, ObjectStatus::kTentative);
  EXPECT_FALSE(waiting->state().evidence.leaves.empty());
  DecideSession(MapConfig(), SessionIdentityParameters(), other, &map_);
  EXPECT_NE(waiting->state().status, ObjectStatus::kTentative);
}

TEST_F(FineSessionIdentityTest, AFewSmallCellsDoNotDecide) {
  TrackedObject* known = PutKnown(0.0, 0);
  // The lowest slice of one side, as thick as it takes for a few cells of 4 cm.
  Box slice(Eigen::Vector3d(1.9, -0.1, -0.1), Eigen::Vector3d(2.1, 0.0, 0.05));
  while (CountLooks(*known).gone < 10) {
    slice.max().y() += 0.02;
    SetScores(slice, -2, known);
  }
  ASSERT_LT(CountLooks(*known).gone, 20U);
  EXPECT_TRUE(Decide().empty());
  SetScores(Box(Eigen::Vector3d(1.9, -1.0, -1.0), Eigen::Vector3d(2.1, 1.0, 1.0)), -2, known);
  EXPECT_EQ(Decide().size(), 1U) << "a whole side";
}

TEST_F(FineSessionIdentityTest, AThirdOfASmallThingDecides) {
  TrackedObject* known = PutKnown(0.0, 0, {0.08, 0.08, 0.1});
  SetScores(Box(Eigen::Vector3d(1.9, -1.0, -1.0), Eigen::Vector3d(2.06, 1.0, 1.0)), -2, known);
  const LookCount looks = CountLooks(*known);
  ASSERT_LT(looks.gone, 25U) << "0.04 square metres";
  ASSERT_GT(3 * looks.gone, looks.cells);
  EXPECT_EQ(Decide().size(), 1U);
}

TEST_F(SessionIdentityTest, WhatIsLeftOfNothingIsNoObject) {
  TrackedObject* seen = PutSeen(0.0, {0.06, 0.06, 0.06});
  SetScores(kEverywhere, -2, seen);
  const LookCount looks = CountLooks(*seen);
  ASSERT_EQ(looks.gone, looks.cells);
  ASSERT_LT(looks.gone, SessionIdentityParameters().parts.min_points) << "told as removed";
  EXPECT_TRUE(Decide().empty());
}

TEST_F(CoarseSessionIdentityTest, TheSurfaceOfOneVoxelHasNoShape) {
  ASSERT_EQ(PutPatch(1)->surface().point_count(), 1U);
  EXPECT_TRUE(Decide().empty());
  EXPECT_TRUE(map_.objects().empty());
  ASSERT_EQ(PutPatch(2)->surface().point_count(), 2U);
  EXPECT_EQ(Decide().size(), 1U);
}

TEST_F(SessionIdentityTest, ASurfaceOfOneFrameIsNoObject) {
  TrackedObject* seen = PutSeen(0.0);
  {
    ObjectEdit edit = map_.Edit(seen);
    edit.state().supporting_frames = 1;
  }
  EXPECT_TRUE(Decide().empty());
  EXPECT_TRUE(map_.objects().empty());
}

}  // namespace
}  // namespace steadymap

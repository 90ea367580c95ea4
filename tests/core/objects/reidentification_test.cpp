#include "core/objects/reidentification.h"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "core/working/working_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;
using ::steadymap::testing::StateOf;
using ::steadymap::testing::StoreVolume;

constexpr ClassId kClass{7};

/// Returns the front of a box that faces -x, from `y_m` along y, 1 m high. If `is_whole`, all
/// voxels of the leaves that the width intersects are observed, else only those within the width.
TrackedObject Front(std::uint64_t id, double y_m, double width_m, bool is_whole = true) {
  const double leaf_m = kScale.leaf_size_m();
  TrackedObject object(ObjectId(id), {0.0, std::floor(y_m / leaf_m) * leaf_m, 0.0}, kScale);
  const double first_m = y_m - object.state().T_world_object.position_world.y();
  StoreVolume(
      testing::MakeVolume(
          [](const Eigen::Vector3d& point) { return 0.2 - point.x(); },
          Box(Eigen::Vector3d(0.05, first_m, 0.0), Eigen::Vector3d(0.35, first_m + width_m, 1.0)),
          kScale,
          [&](const Eigen::Vector3d& point) {
            return is_whole || (point.y() > first_m - 1e-6 && point.y() < first_m + width_m + 1e-6);
          }),
      &object);
  StateOf(&object).class_id = kClass;
  return object;
}

SurfaceOverlap Compare(const TrackedObject& object, const TrackedObject& other) {
  const Eigen::Isometry3d T_other_object = other.state().T_world_object.ToIsometry().inverse() *
                                           object.state().T_world_object.ToIsometry();
  return CompareSurfaces(object, other, T_other_object, kScale);
}

TEST(CompareSurfaces, IsWholeForTheSameSurface) {
  const SurfaceOverlap overlap = Compare(Front(1, 0.0, 0.8), Front(2, 0.0, 0.8));
  EXPECT_NEAR(overlap.known_share, 1.0, 1e-9);
  EXPECT_NEAR(overlap.fit_share, 1.0, 1e-9);
}

TEST(CompareSurfaces, KnowsOnlyThePartThatOverlaps) {
  const SurfaceOverlap overlap = Compare(Front(1, 0.0, 3.2), Front(2, 1.6, 3.2));
  EXPECT_NEAR(overlap.known_share, 0.5, 0.08);
  EXPECT_NEAR(overlap.fit_share, 1.0, 1e-9);
}

TEST(CompareSurfaces, FitsNothingThatLiesTooFarInFront) {
  const TrackedObject object = Front(1, 0.0, 0.8);
  const Eigen::Isometry3d T_other_object(Eigen::Translation3d(-0.1, 0.0, 0.0));
  const SurfaceOverlap overlap =
      CompareSurfaces(object, Front(2, 0.0, 0.8), T_other_object, kScale);
  EXPECT_GT(overlap.known_share, 0.9);
  EXPECT_EQ(overlap.fit_share, 0.0);
}

TEST(CompareSurfaces, FitsNothingThatFacesTheOtherWay) {
  const TrackedObject object = Front(1, 0.0, 0.8);
  // The rotation is about the centre of the front, so that the surface coincides with itself.
  const Eigen::Isometry3d T_other_object = Eigen::Translation3d(0.2, 0.4, 0.0) *
                                           Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()) *
                                           Eigen::Translation3d(-0.2, -0.4, 0.0);
  const SurfaceOverlap overlap =
      CompareSurfaces(object, Front(2, 0.0, 0.8), T_other_object, kScale);
  EXPECT_GT(overlap.known_share, 0.6);
  EXPECT_LT(overlap.fit_share, 0.1);
}

TEST(CompareSurfaces, IsNothingWithoutSurface) {
  const TrackedObject nothing(ObjectId(1), Eigen::Vector3d::Zero(), kScale);
  const SurfaceOverlap overlap = Compare(nothing, Front(2, 0.0, 0.8));
  EXPECT_EQ(overlap.known_share, 0.0);
  EXPECT_EQ(overlap.fit_share, 0.0);
}

class RecognitionArchive : public ::testing::Test {
 protected:
  TrackedObject* Put(TrackedObject object, double gone_s) {
    StateOf(&object).status = ObjectStatus::kArchived;
    StateOf(&object).in_place_since = Timestamp::FromSeconds(gone_s);
    const ObjectId id = object.id();
    return &objects_.try_emplace(id, std::move(object)).first->second;
  }

  TrackedObject* Find(const TrackedObject& object, StationarityPrior prior) {
    return FindReturned(object, kScale, prior, parameters_, Candidates());
  }

  std::vector<TrackedObject*> Candidates() {
    std::vector<TrackedObject*> candidates;
    for (auto& [id, object] : objects_) candidates.push_back(&object);
    return candidates;
  }

  ReidentificationParameters parameters_;
  std::map<ObjectId, TrackedObject> objects_;
};

TEST_F(RecognitionArchive, GivesWhatStoodInThatPlace) {
  Put(Front(1, 2.0, 0.8), 10.0);
  TrackedObject* known = Put(Front(2, 0.0, 0.8), 10.0);
  EXPECT_EQ(Find(Front(3, 0.0, 0.8), StationarityPrior::kMobile), known);
  EXPECT_EQ(Find(Front(3, 5.0, 0.8), StationarityPrior::kMobile), nullptr);
}

TEST_F(RecognitionArchive, GivesAThinFrontThatWasSeenALittleInFront) {
  TrackedObject* known = Put(Front(2, 0.0, 0.8), 10.0);
  TrackedObject object = Front(3, 0.0, 0.8);
  StoreVolume(
      testing::MakeVolume([](const Eigen::Vector3d& point) { return 0.19 - point.x(); },
                          Box(Eigen::Vector3d(0.05, 0.0, 0.0), Eigen::Vector3d(0.35, 0.8, 1.0)),
                          kScale,
                          [](const Eigen::Vector3d&) { return true; }),
      &object);
  ASSERT_FALSE(object.bounds_object().intersects(known->bounds_object()));
  EXPECT_EQ(Find(object, StationarityPrior::kMobile), known);
}

TEST_F(RecognitionArchive, GivesNothingOfAnotherClassOrStillPresent) {
  TrackedObject* known = Put(Front(2, 0.0, 0.8), 10.0);
  TrackedObject other_class = Front(3, 0.0, 0.8);
  StateOf(&other_class).class_id = ClassId(4);
  EXPECT_EQ(Find(other_class, StationarityPrior::kMobile), nullptr);
  StateOf(known).status = ObjectStatus::kPresent;
  EXPECT_EQ(Find(Front(3, 0.0, 0.8), StationarityPrior::kMobile), nullptr);
}

TEST_F(RecognitionArchive, GivesNothingThatIsBeingForgotten) {
  WorkingMap map{MapConfig()};
  const auto put = [&](const TrackedObject& object) {
    TrackedObject* archived = &map.AddPart(object);
    ObjectEdit edit = map.Edit(archived);
    edit.TakeVolume(object);
    edit.state().status = ObjectStatus::kArchived;
    edit.state().in_place_since = Timestamp::FromSeconds(10.0);
    return archived;
  };
  TrackedObject* merged = put(Front(2, 0.0, 0.8));
  const TrackedObject* gone = put(Front(4, 1.2, 0.8));
  const auto find = [&] {
    return FindReturned(
        Front(3, 0.0, 0.8), kScale, StationarityPrior::kMobile, parameters_, map.ArchivedObjects());
  };
  EXPECT_EQ(find(), merged);
  map.Delete(merged);
  EXPECT_EQ(find(), nullptr);
  EXPECT_TRUE(FindGoneWith(*gone, parameters_, map.ArchivedObjects()).empty());
  EXPECT_TRUE(
      FindReturnedParts(Front(3, 0.0, 0.4), kScale, parameters_, map.ArchivedObjects()).empty());
}

TEST_F(RecognitionArchive, GivesNothingThatStoodTurned) {
  TrackedObject* known = Put(Front(2, 0.0, 0.8), 10.0);
  TrackedObject turned = Front(3, 0.0, 0.8);
  StoreVolume(
      testing::MakeVolume(
          [](const Eigen::Vector3d& point) { return 0.2 - point.x() + 0.13 * (point.y() - 0.4); },
          Box(Eigen::Vector3d(0.05, 0.0, 0.0), Eigen::Vector3d(0.35, 0.8, 1.0)),
          kScale,
          [](const Eigen::Vector3d&) { return true; }),
      &turned);
  StateOf(&turned).in_place_since = Timestamp::FromSeconds(100.0);
  EXPECT_EQ(Find(turned, StationarityPrior::kStationary), nullptr);
  parameters_.turn.turned_rad = 0.0;
  EXPECT_EQ(Find(turned, StationarityPrior::kStationary), known) << "distance alone does not tell";
}

TEST_F(RecognitionArchive, AsksLessOfAWallThanOfABox) {
  TrackedObject* known = Put(Front(2, 0.0, 0.8), 10.0);
  TrackedObject beside = Front(3, 0.4, 0.8);
  StateOf(&beside).in_place_since = Timestamp::FromSeconds(100.0);
  EXPECT_EQ(Find(beside, StationarityPrior::kMobile), nullptr);
  EXPECT_EQ(Find(beside, StationarityPrior::kStationary), known);
  StateOf(&beside).in_place_since = Timestamp::FromSeconds(12.0);
  EXPECT_EQ(Find(beside, StationarityPrior::kStationary), nullptr) << "moved along itself";
}

TEST_F(RecognitionArchive, LeavesGoneWhatIsNotFoundAgainOnTheSameVisit) {
  TrackedObject* known = Put(Front(1, 0.0, 1.6), 100.0);
  // All but a quarter of its surface was missed when it was removed.
  for (const SurfaceLeaf& leaf : known->surface().leaves()) {
    LeafEvidence& evidence = StateOf(known).evidence.MutableLeaf(leaf.origin);
    for (const SurfaceVoxel& point : leaf.points) {
      evidence.score[point.cell] = point.position_object.y() > 0.4F ? -3 : 1;
    }
  }
  TrackedObject rest = Front(2, 0.0, 0.4);
  StateOf(&rest).last_seen = Timestamp::FromSeconds(104.0);
  EXPECT_EQ(Find(rest, StationarityPrior::kMobile), nullptr);
  TrackedObject most = Front(3, 0.0, 1.4);
  StateOf(&most).last_seen = Timestamp::FromSeconds(104.0);
  EXPECT_EQ(Find(most, StationarityPrior::kMobile), known) << "what was missed is there again";
  StateOf(&rest).last_seen = Timestamp::FromSeconds(300.0);
  EXPECT_EQ(Find(rest, StationarityPrior::kMobile), known) << "on another visit";
}

TEST_F(RecognitionArchive, KnowsWhatStayedOfOneThatWentOnTheSameVisit) {
  TrackedObject* whole = Put(Front(1, 0.0, 1.6), 100.0);
  const auto find = [&](const TrackedObject& object) {
    return FindWhole(object, kScale, parameters_, Candidates());
  };
  TrackedObject rest = Front(2, 0.0, 0.4);
  StateOf(&rest).last_seen = Timestamp::FromSeconds(104.0);
  EXPECT_EQ(find(rest), whole);
  TrackedObject beside = Front(3, 1.6, 1.2);
  StateOf(&beside).last_seen = Timestamp::FromSeconds(104.0);
  EXPECT_EQ(find(beside), nullptr) << "most of it was never known";
  TrackedObject other_class = rest;
  StateOf(&other_class).class_id = ClassId(4);
  EXPECT_EQ(find(other_class), nullptr);
  StateOf(&rest).last_seen = Timestamp::FromSeconds(300.0);
  EXPECT_EQ(find(rest), nullptr) << "on another visit";
}

/// Present objects that are candidate hosts for a piece.
class RecognitionPieces : public RecognitionArchive {
 protected:
  TrackedObject* Stand(const TrackedObject& object, double since_s) {
    TrackedObject* put = Put(object, since_s);
    StateOf(put).status = ObjectStatus::kPresent;
    return put;
  }

  /// Returns the host of a new piece at `y_m` of width `width_m`, in place since 200 s.
  TrackedObject* Find(double y_m, double width_m, const PieceParameters& parameters) {
    TrackedObject piece = Front(9, y_m, width_m, /*is_whole=*/false);
    StateOf(&piece).in_place_since = Timestamp::FromSeconds(200.0);
    return FindHost(piece, parameters, Candidates());
  }
};

TEST_F(RecognitionPieces, BelongToTheNearestThatStandsNearEnough) {
  Stand(Front(1, 0.0, 0.7), 10.0);
  TrackedObject* near = Stand(Front(2, 1.6, 0.7), 10.0);
  Put(Front(3, 1.2, 0.1), 190.0);
  EXPECT_EQ(Find(1.3, 0.1, parameters_.fixture), near) << "what is archived holds no pieces";
  EXPECT_EQ(Find(3.2, 0.1, parameters_.fixture), nullptr) << "nothing within reach";
  StateOf(near).class_id = ClassId(4);
  EXPECT_EQ(Find(2.6, 0.1, parameters_.fixture), nullptr) << "of another class";
}

TEST_F(RecognitionPieces, AreNoWiderThanThat) {
  Stand(Front(1, 0.0, 0.7), 10.0);
  EXPECT_NE(Find(0.9, 0.2, parameters_.fixture), nullptr);
  EXPECT_EQ(Find(0.9, 0.35, parameters_.fixture), nullptr);
}

TEST_F(RecognitionPieces, OfThingsBelongOnlyToWhatCameOnTheSameVisit) {
  TrackedObject* host = Stand(Front(1, 0.0, 0.7), 10.0);
  EXPECT_EQ(Find(0.8, 0.1, parameters_.thing), nullptr);
  StateOf(host).in_place_since = Timestamp::FromSeconds(190.0);
  EXPECT_EQ(Find(0.8, 0.1, parameters_.thing), host);
}

TEST_F(RecognitionArchive, BringsBackNeighboursThatWentOnTheSameVisit) {
  const TrackedObject* first = Put(Front(1, 0.0, 0.8), 100.0);
  TrackedObject* second = Put(Front(2, 1.2, 0.8), 105.0);
  TrackedObject* third = Put(Front(3, 2.4, 0.8), 110.0);
  Put(Front(4, 6.0, 0.8), 100.0);
  Put(Front(5, -1.2, 0.8), 500.0);
  EXPECT_EQ(FindGoneWith(*first, parameters_, Candidates()),
            (std::vector<TrackedObject*>{second, third}));
}

TEST_F(RecognitionArchive, GivesThePartsOfAWallThatIsUpAgain) {
  TrackedObject* part = Put(Front(1, 0.0, 0.8), 10.0);
  Put(Front(2, 4.0, 0.8), 10.0);
  EXPECT_EQ(FindReturnedParts(Front(3, 0.4, 1.6), kScale, parameters_, Candidates()),
            std::vector<TrackedObject*>{part});
}

}  // namespace
}  // namespace steadymap

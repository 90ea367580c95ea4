#include "core/change/belief_update.h"

#include <gtest/gtest.h>

#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;
using ::steadymap::testing::StateOf;

constexpr Timestamp kNow = Timestamp::FromNanoseconds(100'000'000'000);
constexpr std::uint8_t kCell = 17;
constexpr double kVisitGapS = 20.0;

Timestamp Later(double seconds) {
  return Timestamp::FromNanoseconds(kNow.nanoseconds() + static_cast<std::int64_t>(seconds * 1e9));
}

/// Returns a surface with two leaves.
ObjectSurface TwoLeaves() {
  ObjectSurface surface;
  surface.Rebuild(
      testing::MakeVolume([](const Eigen::Vector3d& point) { return point.x() - 0.1; },
                          Box(Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.39, 0.79, 0.39)),
                          kScale,
                          [](const Eigen::Vector3d&) { return true; }),
      kScale);
  return surface;
}

ObjectVerdict OneCell(Verdict verdict) {
  ObjectVerdict result;
  result.cells = {{1, kCell, verdict}};
  result.present = verdict == Verdict::kPresent ? 1 : 0;
  result.seen_through = verdict == Verdict::kSeenThrough ? 1 : 0;
  result.replaced = verdict == Verdict::kReplaced ? 1 : 0;
  return result;
}

/// Adds the same verdict `times` times. Returns the resulting score of the judged cell.
int ScoreAfter(int times, Verdict verdict, ObjectEvidence* evidence) {
  const ObjectSurface surface = TwoLeaves();
  for (int i = 0; i < times; ++i)
    AddEvidence(OneCell(verdict), surface, kNow, kVisitGapS, evidence);
  return evidence->FindLeaf(surface.leaves()[1].origin)->score[kCell];
}

TEST(AddEvidence, ScoresOnlyTheCellsThatWereJudged) {
  const ObjectSurface surface = TwoLeaves();
  ASSERT_EQ(surface.leaves().size(), 2U);
  ObjectEvidence evidence;
  AddEvidence(OneCell(Verdict::kPresent), surface, kNow, kVisitGapS, &evidence);
  ASSERT_EQ(evidence.leaves.size(), 1U);
  EXPECT_EQ(evidence.leaves[0].origin, surface.leaves()[1].origin);
  for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
    EXPECT_EQ(evidence.leaves[0].score[cell], cell == kCell ? 1 : 0);
  }
}

TEST(AddEvidence, ScoresStayWithinTheirBounds) {
  ObjectEvidence evidence;
  EXPECT_EQ(ScoreAfter(10, Verdict::kPresent, &evidence), kMaxCellScore);
  EXPECT_EQ(ScoreAfter(300, Verdict::kSeenThrough, &evidence), kMinCellScore);
}

TEST(AddEvidence, ReplacedCountsAsGone) {
  ObjectEvidence evidence;
  EXPECT_EQ(ScoreAfter(4, Verdict::kReplaced, &evidence), -4);
  EXPECT_EQ(evidence.absent_cells, 4.0);
}

TEST(AddEvidence, OneLookThatFindsACellOutweighsAllButOneThatMissedIt) {
  ObjectEvidence evidence;
  ScoreAfter(50, Verdict::kSeenThrough, &evidence);
  EXPECT_EQ(ScoreAfter(1, Verdict::kPresent, &evidence), -1);
  EXPECT_EQ(ScoreAfter(1, Verdict::kPresent, &evidence), 0);
}

TEST(AddEvidence, StreakOfAbsenceEndsWhenMoreIsFoundThanMissed) {
  const ObjectSurface surface = TwoLeaves();
  ObjectEvidence evidence;
  ObjectVerdict missing = OneCell(Verdict::kPresent);
  missing.seen_through = 5;
  missing.replaced = 1;
  missing.present = 2;
  AddEvidence(missing, surface, kNow, kVisitGapS, &evidence);
  AddEvidence(missing, surface, kNow, kVisitGapS, &evidence);
  EXPECT_EQ(evidence.absent_streak_cells, 12.0);
  EXPECT_EQ(evidence.absent_cells, 12.0);
  EXPECT_EQ(evidence.present_cells, 4.0);
  ObjectVerdict found;
  found.present = 3;
  found.seen_through = 2;
  AddEvidence(found, surface, kNow, kVisitGapS, &evidence);
  EXPECT_EQ(evidence.absent_streak_cells, 0.0);
  EXPECT_EQ(evidence.absent_cells, 14.0);
}

TEST(AddEvidence, StampsConfirmationsCoarselyAndOnlyWhatWasFound) {
  const ObjectSurface surface = TwoLeaves();
  const LeafOrigin leaf = surface.leaves()[1].origin;
  ObjectEvidence evidence;
  AddEvidence(OneCell(Verdict::kSeenThrough), surface, kNow, kVisitGapS, &evidence);
  EXPECT_EQ(evidence.ConfirmedAt(leaf), Timestamp());
  AddEvidence(OneCell(Verdict::kPresent), surface, kNow, kVisitGapS, &evidence);
  EXPECT_EQ(evidence.ConfirmedAt(leaf), kNow);
  AddEvidence(OneCell(Verdict::kPresent), surface, Later(1.9), kVisitGapS, &evidence);
  EXPECT_EQ(evidence.ConfirmedAt(leaf), kNow);
  AddEvidence(OneCell(Verdict::kPresent), surface, Later(2.0), kVisitGapS, &evidence);
  EXPECT_EQ(evidence.ConfirmedAt(leaf), Later(2.0));
  EXPECT_EQ(evidence.ConfirmedAt(surface.leaves()[0].origin), Timestamp());
}

TEST(AddEvidence, ForgetsWhatWasFoundOnAnEarlierVisitAndNotCounted) {
  const ObjectSurface surface = TwoLeaves();
  ObjectVerdict found = OneCell(Verdict::kPresent);
  found.change_m = 0.1;
  ObjectEvidence evidence;
  AddEvidence(found, surface, kNow, kVisitGapS, &evidence);
  AddEvidence(OneCell(Verdict::kSeenThrough), surface, Later(19.0), kVisitGapS, &evidence);
  EXPECT_EQ(evidence.present_cells, 1.0) << "the same visit";
  for (int i = 1; i <= 3; ++i) {
    AddEvidence(OneCell(Verdict::kSeenThrough), surface, Later(20.0 + i), kVisitGapS, &evidence);
    EXPECT_EQ(evidence.present_cells, 0.0);
    EXPECT_EQ(evidence.change_sum_m, 0.0);
    EXPECT_EQ(evidence.absent_cells, 1.0 + i);
  }
  AddEvidence(found, surface, Later(30.0), kVisitGapS, &evidence);
  AddEvidence(found, surface, Later(31.0), kVisitGapS, &evidence);
  EXPECT_EQ(evidence.present_cells, 2.0);
  EXPECT_DOUBLE_EQ(evidence.change_sum_m, 0.2);
}

TEST(AddEvidence, GathersNothingAgainstWhatRareLooksFind) {
  const ObjectSurface surface = TwoLeaves();
  ObjectVerdict mostly_found = OneCell(Verdict::kPresent);
  mostly_found.present = 9;
  mostly_found.seen_through = 2;
  ObjectEvidence evidence;
  for (int i = 0; i < 20; ++i) {
    AddEvidence(mostly_found, surface, Later(30.0 * i), kVisitGapS, &evidence);
    EXPECT_EQ(evidence.present_cells, 9.0);
    EXPECT_EQ(evidence.absent_cells, 2.0);
  }
}

TEST(AddEvidence, SaysNothingWithoutJudgedCells) {
  ObjectEvidence evidence;
  evidence.absent_streak_cells = 5.0;
  const ObjectEvidence before = evidence;
  AddEvidence(ObjectVerdict(), TwoLeaves(), kNow, kVisitGapS, &evidence);
  EXPECT_EQ(evidence, before);
}

TEST(AddEvidence, WeighsChangesByTheCellsTheyWereMeasuredOn) {
  ObjectEvidence evidence;
  ObjectVerdict found = OneCell(Verdict::kPresent);
  found.present = 5;
  found.seen_through = 9;
  found.change_m = 0.1;
  AddEvidence(found, TwoLeaves(), kNow, kVisitGapS, &evidence);
  found.present = 10;
  found.change_m = -0.02;
  AddEvidence(found, TwoLeaves(), kNow, kVisitGapS, &evidence);
  found.change_m.reset();
  AddEvidence(found, TwoLeaves(), kNow, kVisitGapS, &evidence);
  EXPECT_NEAR(evidence.change_sum_m, 0.3, 1e-12);
}

MapObject ObjectWith(double present_cells, double absent_cells) {
  MapObject object;
  object.belief = InitialBelief(0.67);
  object.evidence.present_cells = present_cells;
  object.evidence.absent_cells = absent_cells;
  return object;
}

bool Update(MapObject* object) {
  return UpdateBelief(StationarityPrior::kMobile, kNow, BeliefUpdateParameters(), object);
}

TEST(UpdateBelief, WaitsForEnoughCells) {
  MapObject object = ObjectWith(7.0, 7.0);
  EXPECT_FALSE(Update(&object));
  EXPECT_EQ(object.belief, InitialBelief(0.67));
  EXPECT_EQ(object.evidence.present_cells, 7.0);
  EXPECT_EQ(object.evidence.absent_cells, 7.0);
  object.evidence.absent_cells = 8.0;
  EXPECT_TRUE(Update(&object));
}

TEST(UpdateBelief, RisesWhereTheSurfaceWasFound) {
  MapObject object = ObjectWith(17.0, 3.0);
  EXPECT_TRUE(Update(&object));
  EXPECT_GT(object.belief.stationarity(), 0.67);
  EXPECT_EQ(object.last_seen, kNow);
  EXPECT_EQ(object.contradicted_updates, 0U);
  EXPECT_EQ(object.evidence.present_cells, 0.0);
  EXPECT_EQ(object.evidence.absent_cells, 0.0);
}

TEST(UpdateBelief, FallsWhereTheSurfaceIsGone) {
  MapObject object = ObjectWith(13.0, 7.0);
  EXPECT_TRUE(Update(&object));
  EXPECT_LT(object.belief.stationarity(), 0.67);
  EXPECT_EQ(object.last_seen, Timestamp());
  EXPECT_EQ(object.contradicted_updates, 1U);
}

TEST(UpdateBelief, TakesTheMeanChangeOfTheSurfaceThatWasFound) {
  MapObject object = ObjectWith(20.0, 3.0);
  object.evidence.change_sum_m = 20.0 * -0.05;
  EXPECT_TRUE(Update(&object));
  const StationarityUpdate expected = UpdateStationarity(
      InitialBelief(0.67), -0.05, StationarityPrior::kMobile, StationarityParameters());
  EXPECT_EQ(object.belief, expected.belief);
  EXPECT_EQ(object.evidence.change_sum_m, 0.0);
}

TEST(UpdateBelief, TakesTheGreatestChangeWhereTheSurfaceIsGone) {
  MapObject object = ObjectWith(10.0, 10.0);
  object.evidence.change_sum_m = 10.0 * 0.05;
  EXPECT_TRUE(Update(&object));
  const StationarityParameters parameters;
  const StationarityUpdate expected = UpdateStationarity(
      InitialBelief(0.67), parameters.max_change_m, StationarityPrior::kMobile, parameters);
  EXPECT_EQ(object.belief, expected.belief);
  EXPECT_EQ(object.evidence.change_sum_m, 0.0);
}

TEST(UpdateBelief, SaysNothingInBetweenButStartsAnew) {
  for (const double absent_cells : {4.0, 6.0}) {
    MapObject object = ObjectWith(20.0 - absent_cells, absent_cells);
    EXPECT_TRUE(Update(&object));
    EXPECT_EQ(object.belief, InitialBelief(0.67)) << absent_cells;
    EXPECT_EQ(object.contradicted_updates, 0U);
    EXPECT_EQ(object.last_seen, Timestamp());
    EXPECT_EQ(object.evidence.present_cells, 0.0);
    EXPECT_EQ(object.evidence.absent_cells, 0.0);
  }
}

/// Returns the number of updates with absence alone until the stationarity falls below 0.40, after
/// `agreements_before` updates with presence.
int AbsencesUntilRemoval(StationarityPrior prior, int agreements_before) {
  MapObject object = ObjectWith(0.0, 0.0);
  for (int i = 0; i < agreements_before; ++i) {
    object.evidence.present_cells = 15.0;
    UpdateBelief(prior, kNow, BeliefUpdateParameters(), &object);
  }
  int absences = 0;
  while (object.belief.stationarity() >= 0.40 && absences < 100) {
    object.evidence.absent_cells = 15.0;
    UpdateBelief(prior, kNow, BeliefUpdateParameters(), &object);
    ++absences;
  }
  return absences;
}

TEST(UpdateBelief, TakesMoreAbsencesToLoseWhatWasLongKnownOrIsExpectedToStay) {
  const int moving_new = AbsencesUntilRemoval(StationarityPrior::kMobile, 0);
  const int moving_known = AbsencesUntilRemoval(StationarityPrior::kMobile, 50);
  const int staying_known = AbsencesUntilRemoval(StationarityPrior::kStationary, 50);
  EXPECT_LT(moving_new, moving_known);
  EXPECT_LT(moving_known, staying_known);
  EXPECT_LE(staying_known, 20) << "nothing is known for ever";
}

TEST(UpdateBelief, TakesFewerAbsencesToLoseWhatWasKnownFromAnEarlierVisit) {
  const BeliefUpdateParameters parameters;
  for (const StationarityPrior prior :
       {StationarityPrior::kStationary, StationarityPrior::kMobile}) {
    MapObject object = ObjectWith(0.0, 0.0);
    for (int i = 0; i < 50; ++i) {
      object.evidence.present_cells = 15.0;
      UpdateBelief(prior, kNow, parameters, &object);
    }
    const Timestamp next_visit =
        Timestamp::FromSeconds(kNow.seconds() + parameters.visit_gap_s + 1.0);
    int absences = 0;
    for (; object.belief.stationarity() >= 0.40 && absences < 100; ++absences) {
      object.evidence.absent_cells = 15.0;
      UpdateBelief(prior, next_visit, parameters, &object);
    }
    const int on_one_visit = AbsencesUntilRemoval(prior, 50);
    if (prior == StationarityPrior::kStationary) {
      EXPECT_LT(absences, on_one_visit);
      EXPECT_GE(absences, 3) << "one bad look removes no wall";
    } else {
      EXPECT_EQ(absences, on_one_visit);
    }
  }
}

/// Returns an object whose surface is a plane of 4 m by 0.8 m, last observed at `kNow`.
TrackedObject FoundNow() {
  TrackedObject object(ObjectId(1), Eigen::Vector3d::Zero(), kScale);
  testing::StoreVolume(
      testing::MakeVolume([](const Eigen::Vector3d& point) { return point.x() - 0.1; },
                          Box(Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.39, 3.99, 0.79)),
                          kScale,
                          [](const Eigen::Vector3d&) { return true; }),
      &object);
  StateOf(&object).last_seen = kNow;
  return object;
}

TEST(IsContradicted, TakesMoreThanTheSameFewCellsOnOneVisit) {
  TrackedObject object = FoundNow();
  const ContradictionParameters parameters;
  ObjectVerdict verdict;
  verdict.seen_through = 3;
  EXPECT_FALSE(IsContradicted(verdict, Later(20.0), parameters, object));
  EXPECT_TRUE(IsContradicted(verdict, Later(61.0), parameters, object)) << "on another visit";
  verdict.replaced = 7;
  EXPECT_TRUE(IsContradicted(verdict, Later(20.0), parameters, object));
}

TEST(IsContradicted, CountsWhatEarlierFramesMissed) {
  TrackedObject object = FoundNow();
  ObjectVerdict verdict;
  verdict.seen_through = 1;
  LeafEvidence& evidence =
      StateOf(&object).evidence.MutableLeaf(object.surface().leaves()[0].origin);
  evidence.score.fill(-1);
  EXPECT_TRUE(IsContradicted(verdict, Later(20.0), ContradictionParameters(), object));
  evidence.score.fill(0);
  EXPECT_FALSE(IsContradicted(verdict, Later(20.0), ContradictionParameters(), object));
}

TEST(IsContradicted, LeavesWhatWasFoundAMomentAgoButForAnEdge) {
  TrackedObject object = FoundNow();
  ObjectVerdict verdict;
  verdict.seen_through = 11;
  const Timestamp next_visit = Later(90.0);
  std::size_t found = 0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    LeafEvidence& evidence = StateOf(&object).evidence.MutableLeaf(leaf.origin);
    evidence.confirmed = Later(80.0);
    for (const SurfaceVoxel& point : leaf.points) {
      found += evidence.score[point.cell] == 0 ? 1U : 0U;
      evidence.score[point.cell] = 1;
    }
  }
  ContradictionParameters parameters;
  parameters.found_ratio = static_cast<double>(found) / 11.0 - 0.1;
  EXPECT_FALSE(IsContradicted(verdict, next_visit, parameters, object));
  EXPECT_TRUE(IsContradicted(verdict, Later(101.0), parameters, object)) << "too long ago";
  StateOf(&object).belief = InitialBelief(0.19);
  EXPECT_TRUE(IsContradicted(verdict, next_visit, parameters, object)) << "hardly believed";
  StateOf(&object).belief = InitialBelief(0.21);
  EXPECT_FALSE(IsContradicted(verdict, next_visit, parameters, object));
  parameters.found_ratio = static_cast<double>(found) / 11.0 + 0.1;
  EXPECT_TRUE(IsContradicted(verdict, next_visit, parameters, object)) << "too few";
}

TEST(IsContradicted, TakesAShareOfSmallObjects) {
  TrackedObject object = FoundNow();
  const auto cells = static_cast<double>(object.surface().point_count()) / 4.0;
  ContradictionParameters parameters;
  parameters.cells = 1000;
  ObjectVerdict verdict;
  verdict.seen_through = 3;
  parameters.share = 4.0 / cells;
  EXPECT_FALSE(IsContradicted(verdict, Later(20.0), parameters, object));
  parameters.share = 2.0 / cells;
  EXPECT_TRUE(IsContradicted(verdict, Later(20.0), parameters, object));
}

}  // namespace
}  // namespace steadymap

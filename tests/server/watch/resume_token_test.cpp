#include "server/watch/resume_token.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

const WatchScope kHallScope{MapKey(3), "tenants/test/maps/hall", "incarnation-1", 42};
const WatchPosition kHallPosition{Revision(1ULL << 40), EventNumber(99)};

TEST(ResumeToken, HoldsThePosition) {
  for (const bool has_leaves : {true, false}) {
    WatchPosition position = kHallPosition;
    position.has_leaves = has_leaves;
    const std::string token = MakeResumeToken(kHallScope, position);
    EXPECT_LE(token.size(), 256U);
    const absl::StatusOr<ResumeToken> read = ReadResumeToken(kHallScope, token);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->position, position);
    EXPECT_TRUE(read->fit.ok()) << read->fit;
  }
}

const StepKey kHallStep{
    kHallScope, kHallPosition, {Revision(1ULL << 41), 77}, 65'536, true, false, true};

TEST(ResumeToken, HoldsThePlaceInAStep) {
  StepKey snapshot = kHallStep;
  snapshot.before = {};
  snapshot.takes_patches = snapshot.is_shown_known = false;
  snapshot.as_snapshot = true;
  for (const StepKey& step : {kHallStep, snapshot}) {
    const std::string token = MakeStepToken(step, 12);
    EXPECT_LE(token.size(), 256U);
    const absl::StatusOr<ResumeToken> read = ReadResumeToken(kHallScope, token);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->step, step);
    EXPECT_EQ(read->place, 12U);
    EXPECT_EQ(read->position, step.before);
    EXPECT_TRUE(read->fit.ok());
  }
  const auto between = ReadResumeToken(kHallScope, MakeResumeToken(kHallScope, kHallPosition));
  EXPECT_FALSE(between->step.has_value());
}

class DamagedToken : public ::testing::TestWithParam<std::string> {};

TEST_P(DamagedToken, IsRefusedWhereverTheDamageIs) {
  const std::string& token = GetParam();
  for (std::size_t i = 0; i < token.size(); ++i) {
    for (const int bit : {0, 3, 7}) {
      std::string damaged = token;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      const absl::Status status = ReadResumeToken(kHallScope, damaged).status();
      EXPECT_EQ(ReasonOf(status), reason::kBadResumeToken) << i;
      EXPECT_EQ(FieldOf(status), "resume_token");
    }
    EXPECT_EQ(ReasonOf(ReadResumeToken(kHallScope, token.substr(0, i)).status()),
              reason::kBadResumeToken);
  }
  EXPECT_EQ(ReasonOf(ReadResumeToken(kHallScope, token + "x").status()), reason::kBadResumeToken);
}

/// Returns how a token of the hall fits another scope.
absl::Status FitOf(const WatchScope& scope) {
  const auto read = ReadResumeToken(scope, MakeResumeToken(kHallScope, kHallPosition));
  return read.ok() ? read->fit : read.status();
}

INSTANTIATE_TEST_SUITE_P(ResumeToken,
                         DamagedToken,
                         ::testing::Values(MakeResumeToken(kHallScope, kHallPosition),
                                           MakeStepToken(kHallStep, 3)));

TEST(ResumeToken, OfAnotherFilterNamesTheFilter) {
  WatchScope scope = kHallScope;
  scope.filter = 43;
  const absl::Status fit = FitOf(scope);
  EXPECT_TRUE(absl::IsInvalidArgument(fit));
  EXPECT_EQ(ReasonOf(fit), reason::kBadResumeToken);
  EXPECT_EQ(FieldOf(fit), "filter");
}

TEST(ResumeToken, OfAnotherMapIsABadToken) {
  WatchScope scope = kHallScope;
  scope.map_name = "tenants/test/maps/yard";
  scope.map = MapKey(4);
  const absl::Status fit = FitOf(scope);
  EXPECT_TRUE(absl::IsInvalidArgument(fit));
  EXPECT_EQ(ReasonOf(fit), reason::kBadResumeToken);
  EXPECT_EQ(FieldOf(fit), "resume_token");
}

TEST(ResumeToken, OfAHistoryThatWasReplacedIsBehindIt) {
  WatchScope made_anew = kHallScope;
  made_anew.map = MapKey(4);
  WatchScope restored = kHallScope;
  restored.incarnation = "incarnation-2";
  for (const WatchScope& scope : {made_anew, restored}) {
    const absl::Status fit = FitOf(scope);
    EXPECT_TRUE(absl::IsOutOfRange(fit));
    EXPECT_EQ(ReasonOf(fit), reason::kRevisionCompacted);
  }
}

Box MakeBox(double min_x) {
  return {Eigen::Vector3d(min_x, 0.0, -1.0), Eigen::Vector3d(min_x + 1.0, 2.0, 1.0)};
}

TEST(FilterFingerprint, DiffersWhereFiltersDo) {
  const MapFilter everything;
  MapFilter archived;
  archived.archived = true;
  MapFilter classes;
  classes.classes = {ClassId(1)};
  MapFilter objects;
  objects.objects = {ObjectId(1)};
  MapFilter box;
  box.boxes_world = {MakeBox(0.0)};
  MapFilter other_box;
  other_box.boxes_world = {MakeBox(0.5)};
  MapFilter events;
  events.states = events.volumes = false;
  MapFilter states;
  states.volumes = false;
  const std::vector<MapFilter> filters = {
      everything, archived, classes, objects, box, other_box, events, states};
  for (std::size_t i = 0; i < filters.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_NE(FingerprintOf(filters[i]), FingerprintOf(filters[j])) << i << ' ' << j;
    }
  }
}

TEST(FilterFingerprint, KnowsNoOrderAndNoRepetitionOfBoxes) {
  MapFilter filter;
  filter.boxes_world = {MakeBox(0.0), MakeBox(3.0)};
  MapFilter same;
  same.boxes_world = {MakeBox(3.0), MakeBox(-0.0), MakeBox(3.0)};
  EXPECT_EQ(FingerprintOf(filter), FingerprintOf(same));
}

TEST(FilterFingerprint, VolumesComeWithTheStates) {
  MapFilter named;
  MapFilter implied;
  implied.states = false;
  EXPECT_EQ(FingerprintOf(named), FingerprintOf(implied));
}

}  // namespace
}  // namespace steadymap

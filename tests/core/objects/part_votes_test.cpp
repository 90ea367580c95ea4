#include "core/objects/part_votes.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::StoreVolume;

const Eigen::Vector3d kPartSizeM(0.4, 0.4, 0.4);

class PartVotesTest : public ::testing::Test {
 protected:
  PartVotesTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  /// Adds a box of the session with its lowest corner at `x_m`.
  TrackedObject* Put(double x_m, const Eigen::Vector3d& size_m = kPartSizeM) {
    const Eigen::Vector3d place(x_m, 0.0, 0.0);
    TrackedObject& object = map_.AddObject(place);
    const Eigen::Vector3d low = place - object.state().T_world_object.position_world;
    ObjectEdit edit = map_.Edit(&object);
    StoreVolume(MakeVolume({Box(low, low + size_m)}, map_.scale()), &edit);
    return &object;
  }

  PartElection Elect() { return PartElection(map_.TentativeObjects(), {}, 0.2); }

  WorkingMap map_{MapConfig()};
};

TEST_F(PartVotesTest, ObjectsThatMostFramesConnectAreOne) {
  TrackedObject* a = Put(0.0);
  TrackedObject* b = Put(0.5);
  for (int i = 0; i < 8; ++i) VoteOnParts(PartVote::kConnected, b, a, &map_);
  for (int i = 0; i < 4; ++i) VoteOnParts(PartVote::kApart, a, b, &map_);
  EXPECT_EQ(Elect().FindPair(), (PartElection::Pair{a->id(), b->id()}));
  EXPECT_FALSE(Elect().AreApart(a->id(), b->id()));
}

TEST_F(PartVotesTest, OneFrameThatConnectsTwoObjectsDecidesNothing) {
  TrackedObject* a = Put(0.0);
  TrackedObject* b = Put(0.5);
  VoteOnParts(PartVote::kConnected, a, b, &map_);
  for (int i = 0; i < 20; ++i) VoteOnParts(PartVote::kApart, a, b, &map_);
  EXPECT_EQ(Elect().FindPair(), PartElection::Pair());
  EXPECT_TRUE(Elect().AreApart(a->id(), b->id()));
}

TEST_F(PartVotesTest, ObjectsThatAreFarAwayNeedNoVotes) {
  TrackedObject* a = Put(0.0);
  TrackedObject* b = Put(2.0);
  VoteOnParts(PartVote::kApart, a, b, &map_);
  EXPECT_TRUE(b->state().parts.empty());
  EXPECT_FALSE(Elect().AreApart(a->id(), b->id()));
}

TEST_F(PartVotesTest, APartInheritsTheVotesOfTheWhole) {
  TrackedObject* older = Put(0.0);
  TrackedObject* whole = Put(0.5);
  TrackedObject* newer = Put(1.0);
  VoteOnParts(PartVote::kConnected, whole, older, &map_);
  VoteOnParts(PartVote::kConnected, newer, whole, &map_);
  VoteOnParts(PartVote::kConnected, newer, whole, &map_);
  {
    ObjectEdit edit = map_.Edit(whole);
    edit.state().supporting_frames = 5;
  }
  TrackedObject* part = Put(0.6);
  InheritVotes(*whole, part, &map_);
  const std::vector<PartVotes> expected = {
      {older->id(), 1, 0}, {whole->id(), 5, 0}, {newer->id(), 2, 0}};
  EXPECT_EQ(part->state().parts, expected);
}

TEST_F(PartVotesTest, VotesOnAJoinedPartCountForTheWhole) {
  TrackedObject* a = Put(0.0);
  TrackedObject* b = Put(0.5);
  TrackedObject* c = Put(1.0);
  VoteOnParts(PartVote::kConnected, a, b, &map_);
  VoteOnParts(PartVote::kConnected, a, c, &map_);
  for (int i = 0; i < 3; ++i) VoteOnParts(PartVote::kConnected, b, c, &map_);
  for (int i = 0; i < 40; ++i) VoteOnParts(PartVote::kApart, a, c, &map_);
  PartElection election = Elect();
  election.Join(b->id(), a->id());
  EXPECT_TRUE(election.AreApart(a->id(), c->id()));
  EXPECT_EQ(election.FindPair(), PartElection::Pair());
}

// At the border of two stacked boxes, each frame connects a strip with one of them.
TEST_F(PartVotesTest, AFragmentBetweenTwoObjectsDoesNotConnectThem) {
  TrackedObject* lower = Put(0.0);
  TrackedObject* upper = Put(0.4);
  TrackedObject* strip = Put(0.4, {0.05, 0.1, 0.1});
  for (int i = 0; i < 50; ++i) VoteOnParts(PartVote::kApart, lower, upper, &map_);
  for (int i = 0; i < 40; ++i) VoteOnParts(PartVote::kConnected, strip, lower, &map_);
  for (int i = 0; i < 20; ++i) VoteOnParts(PartVote::kConnected, strip, upper, &map_);
  PartElection election = Elect();
  election.Join(strip->id(), lower->id());
  EXPECT_TRUE(election.AreApart(lower->id(), upper->id()));
  EXPECT_EQ(election.FindPair(), PartElection::Pair());
}

TEST_F(PartVotesTest, ADecisionOnAPairPrevailsOverItsVotes) {
  TrackedObject* a = Put(0.0);
  TrackedObject* b = Put(0.5);
  TrackedObject* c = Put(1.0);
  for (int i = 0; i < 9; ++i) VoteOnParts(PartVote::kConnected, a, b, &map_);
  for (int i = 0; i < 9; ++i) VoteOnParts(PartVote::kApart, b, c, &map_);
  const PartDecisions decisions = {{PairOf(a->id(), b->id()), false},
                                   {PairOf(b->id(), c->id()), true}};
  PartElection election(map_.TentativeObjects(), decisions, 0.2);
  EXPECT_TRUE(election.AreApart(a->id(), b->id()));
  EXPECT_FALSE(election.AreApart(b->id(), c->id()));
  EXPECT_EQ(election.FindPair(), PairOf(b->id(), c->id()));
  // What is apart from a part is apart from the whole.
  election.Join(c->id(), b->id());
  EXPECT_EQ(election.FindPair(), PartElection::Pair());
  EXPECT_TRUE(election.AreApart(a->id(), b->id()));
}

TEST_F(PartVotesTest, WhatHidesAnotherObjectShowsNoGap) {
  TrackedObject* rim = Put(0.0);
  TrackedObject* lid = Put(0.5);
  for (int i = 0; i < 9; ++i) VoteOnParts(PartVote::kOccluded, rim, lid, &map_);
  EXPECT_TRUE(Elect().AreApart(rim->id(), lid->id()));
  EXPECT_FALSE(Elect().IsGapSeen(rim->id(), lid->id()));
  VoteOnParts(PartVote::kApart, rim, lid, &map_);
  EXPECT_TRUE(Elect().IsGapSeen(rim->id(), lid->id()));
  // One frame in two that tells connects them, though most show only that one hides the other.
  VoteOnParts(PartVote::kConnected, rim, lid, &map_);
  EXPECT_TRUE(Elect().AreApart(rim->id(), lid->id()));
  EXPECT_FALSE(Elect().IsGapSeen(rim->id(), lid->id()));
}

TEST_F(PartVotesTest, ADecisionOnAPairShowsAGap) {
  TrackedObject* a = Put(0.0);
  TrackedObject* b = Put(0.5);
  VoteOnParts(PartVote::kOccluded, a, b, &map_);
  const PartDecisions decisions = {{PairOf(a->id(), b->id()), false}};
  EXPECT_TRUE(PartElection(map_.TentativeObjects(), decisions, 0.2).IsGapSeen(a->id(), b->id()));
}

TEST_F(PartVotesTest, VotesOnADeletedObjectAreIgnored) {
  TrackedObject* a = Put(0.0);
  TrackedObject* b = Put(0.5);
  VoteOnParts(PartVote::kConnected, a, b, &map_);
  map_.Delete(a);
  EXPECT_EQ(Elect().FindPair(), PartElection::Pair());
}

}  // namespace
}  // namespace steadymap

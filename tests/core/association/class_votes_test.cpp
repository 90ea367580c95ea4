#include "core/association/class_votes.h"

#include <gtest/gtest.h>

namespace steadymap {
namespace {

TEST(AddVotes, SharesOneVoteOutByTheSamplesOfEachClass) {
  MapObject object;
  AddVotes({{ClassId(7), 30}, {ClassId(4), 10}}, &object);
  EXPECT_EQ(object.votes, (std::vector<ClassVote>{{ClassId(4), 0.25}, {ClassId(7), 0.75}}));
  EXPECT_EQ(object.class_id, ClassId(7));
}

TEST(AddVotes, LetsManyFramesOutvoteOne) {
  MapObject object;
  AddVotes({{ClassId(9), 5000}}, &object);
  AddVotes({{ClassId(7), 20}}, &object);
  AddVotes({{ClassId(7), 20}}, &object);
  EXPECT_EQ(object.class_id, ClassId(7));
  EXPECT_EQ(object.votes, (std::vector<ClassVote>{{ClassId(7), 2.0}, {ClassId(9), 1.0}}));
}

TEST(AddVotes, TakesTheLowerClassOfEqualOnes) {
  MapObject object;
  AddVotes({{ClassId(9), 8}, {ClassId(7), 8}}, &object);
  EXPECT_EQ(object.class_id, ClassId(7));
}

TEST(JoinVotes, AddsThoseOfAPart) {
  MapObject whole;
  AddVotes({{ClassId(4), 16}}, &whole);
  MapObject part;
  AddVotes({{ClassId(7), 100}}, &part);
  AddVotes({{ClassId(7), 100}}, &part);
  JoinVotes(part.votes, &whole);
  EXPECT_EQ(whole.class_id, ClassId(7));
  EXPECT_EQ(whole.votes, (std::vector<ClassVote>{{ClassId(4), 1.0}, {ClassId(7), 2.0}}));
}

TEST(AddVotes, ChangesNothingWithoutSamples) {
  MapObject object;
  object.class_id = ClassId(5);
  AddVotes({}, &object);
  EXPECT_TRUE(object.votes.empty());
  EXPECT_EQ(object.class_id, ClassId(5));
}

}  // namespace
}  // namespace steadymap

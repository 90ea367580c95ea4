#include "server/mapping/session_table.h"

#include <gtest/gtest.h>

namespace steadymap {
namespace {

const SessionName kName{{"robot", SensorName::kDefaultSensor}, "session"};

SessionRecord MakeRecord(std::uint64_t through,
                         std::uint64_t last_map_seq,
                         std::int64_t active_s = 1) {
  SessionRecord record;
  record.name = kName;
  record.settled.InsertThrough(ClientSequence(through));
  record.last_map_seq = MapSequence(last_map_seq);
  record.last_active = std::chrono::seconds(active_s);
  return record;
}

TEST(SessionTable, UnknownSessionStandsAtTheBeginning) {
  SessionTable table({}, MapSequence(9));
  EXPECT_EQ(table.State(kName, MapSequence(9)).durable, ClientSequence(0));
  EXPECT_FALSE(table.IsSettled(kName, ClientSequence(1)));
  EXPECT_EQ(table.Get(kName).name, kName);
  EXPECT_EQ(table.size(), 0U);
}

TEST(SessionTable, IntegrationFollowsTheRevision) {
  SessionTable table({}, MapSequence(0));
  table.Update(MakeRecord(3, 10));
  table.Update(MakeRecord(7, 20));
  EXPECT_EQ(table.State(kName, MapSequence(9)).durable, ClientSequence(7));
  EXPECT_EQ(table.State(kName, MapSequence(9)).integrated, ClientSequence(0));
  EXPECT_EQ(table.State(kName, MapSequence(10)).integrated, ClientSequence(3));
  EXPECT_EQ(table.State(kName, MapSequence(19)).integrated, ClientSequence(3));
  EXPECT_EQ(table.State(kName, MapSequence(20)).integrated, ClientSequence(7));
}

TEST(SessionTable, RestoredSessionIsIntegratedIfItsNewestFrameIs) {
  SessionTable integrated({MakeRecord(7, 20)}, MapSequence(20));
  EXPECT_EQ(integrated.State(kName, MapSequence(20)).integrated, ClientSequence(7));
  SessionTable behind({MakeRecord(7, 20)}, MapSequence(19));
  EXPECT_EQ(behind.State(kName, MapSequence(19)).integrated, ClientSequence(0));
  EXPECT_EQ(behind.State(kName, MapSequence(20)).integrated, ClientSequence(7));
}

TEST(SessionTable, SessionThatNobodyAsksAboutDoesNotGrowWithoutBound) {
  SessionTable table({}, MapSequence(0));
  for (std::uint64_t i = 1; i <= 5000; ++i) table.Update(MakeRecord(i, i));
  // The newest milestones are merged; the reported integrated frames are never too many.
  EXPECT_EQ(table.State(kName, MapSequence(500)).integrated, ClientSequence(500));
  EXPECT_LE(table.State(kName, MapSequence(4999)).integrated, ClientSequence(4999));
  EXPECT_EQ(table.State(kName, MapSequence(5000)).integrated, ClientSequence(5000));
}

TEST(SessionTable, IdleSessionsAreForgotten) {
  SessionTable table({MakeRecord(7, 20, 100)}, MapSequence(20));
  table.ForgetIdle(std::chrono::seconds(100), {});
  EXPECT_TRUE(table.IsSettled(kName, ClientSequence(7)));
  table.ForgetIdle(std::chrono::seconds(101), {kName});
  EXPECT_TRUE(table.IsSettled(kName, ClientSequence(7))) << "it is in use";
  table.ForgetIdle(std::chrono::seconds(101), {});
  EXPECT_FALSE(table.IsSettled(kName, ClientSequence(7)));
}

}  // namespace
}  // namespace steadymap

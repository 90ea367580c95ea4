#include "server/mapping/frame_queue.h"

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::size_t kAnyBytes = std::numeric_limits<std::size_t>::max();

PendingBatch MakeBatch(const std::string& robot, std::uint64_t last, std::size_t frames) {
  PendingBatch batch;
  batch.session = {{robot, SensorName::kDefaultSensor}, "session"};
  batch.last = ClientSequence(last);
  batch.frames.resize(frames);
  return batch;
}

std::string Order(const std::vector<PendingBatch>& batches) {
  std::string order;
  for (const PendingBatch& batch : batches) {
    order += batch.session.sensor.robot + std::to_string(batch.last.value()) + " ";
  }
  return order;
}

TEST(FrameQueue, RobotsTakeTurnsAndKeepTheirOrder) {
  FrameQueue queue(100);
  for (std::uint64_t i = 1; i <= 4; ++i) ASSERT_TRUE(queue.Push(MakeBatch("a", i, 1)).ok());
  ASSERT_TRUE(queue.Push(MakeBatch("b", 1, 1)).ok());
  ASSERT_TRUE(queue.Push(MakeBatch("c", 1, 1)).ok());
  EXPECT_EQ(Order(queue.PopFair(100, kAnyBytes)), "a1 b1 c1 a2 a3 a4 ");
}

TEST(FrameQueue, TurnGoesOnWhereTheLastPopStopped) {
  FrameQueue queue(100);
  for (std::uint64_t i = 1; i <= 2; ++i) {
    ASSERT_TRUE(queue.Push(MakeBatch("a", i, 1)).ok());
    ASSERT_TRUE(queue.Push(MakeBatch("b", i, 1)).ok());
  }
  EXPECT_EQ(Order(queue.PopFair(1, kAnyBytes)), "a1 ");
  EXPECT_EQ(Order(queue.PopFair(1, kAnyBytes)), "b1 ");
  EXPECT_EQ(Order(queue.PopFair(2, kAnyBytes)), "a2 b2 ");
  EXPECT_TRUE(queue.PopFair(1, kAnyBytes).empty());
}

TEST(FrameQueue, FullQueueRefuses) {
  FrameQueue queue(4);
  ASSERT_TRUE(queue.Push(MakeBatch("a", 1, 3)).ok());
  const absl::Status status = queue.Push(MakeBatch("b", 1, 2));
  EXPECT_EQ(ReasonOf(status), "QUEUE_FULL");
  EXPECT_TRUE(queue.Push(MakeBatch("b", 1, 1)).ok());
  EXPECT_EQ(queue.waiting_frames(), 4U);
  queue.PopFair(100, kAnyBytes);
  EXPECT_EQ(queue.waiting_frames(), 0U);
}

TEST(FrameQueue, BatchLargerThanTheQueueIsTakenAlone) {
  FrameQueue queue(4);
  EXPECT_TRUE(queue.Push(MakeBatch("a", 1, 9)).ok());
  EXPECT_FALSE(queue.Push(MakeBatch("a", 2, 1)).ok());
}

TEST(FrameQueue, BatchesWithoutFramesAreBoundedToo) {
  FrameQueue queue(2);
  EXPECT_TRUE(queue.Push(MakeBatch("a", 1, 0)).ok());
  EXPECT_TRUE(queue.Push(MakeBatch("a", 2, 0)).ok());
  EXPECT_FALSE(queue.Push(MakeBatch("a", 3, 0)).ok());
}

TEST(FrameQueue, ClosedQueueGivesBackWhatWaitedAndRefuses) {
  FrameQueue queue(10);
  ASSERT_TRUE(queue.Push(MakeBatch("a", 1, 1)).ok());
  EXPECT_EQ(Order(queue.Close(absl::NotFoundError("gone"))), "a1 ");
  EXPECT_EQ(queue.Push(MakeBatch("a", 2, 1)).code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(queue.PopFair(10, kAnyBytes).empty());
}

}  // namespace
}  // namespace steadymap

#include <future>
#include <string>

#include <gtest/gtest.h>

#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/eventually.h"

namespace steadymap {
namespace {

using absl::StatusCode;
using ::steadymap::testing::Eventually;

class StoreFaultContract : public ::testing::Test {
 protected:
  TestService service_{Transport::kLoopback};
  const std::string map_ = service_.CreateMap("hall");
  const UploadSession session_{map_};
};

TEST_F(StoreFaultContract, AFailedAppendMakesThatMapReadOnlyUntilTheDiskIsSound) {
  const UploadSession other{service_.CreateMap("yard")};
  ASSERT_TRUE(UploadAndClose(&service_, session_, MakeBatch(1, 2)).ok());
  service_.store().FailNextAppend();
  EXPECT_THAT(UploadAndClose(&service_, session_, MakeBatch(3, 2)),
              IsError(StatusCode::kUnavailable, "STORE_READ_ONLY", ""));
  v1::MapState state = service_.GetMap(map_)->state();
  EXPECT_EQ(state.revision(), 2U);
  EXPECT_EQ(state.condition(), v1::MAP_CONDITION_READ_ONLY);
  EXPECT_NE(state.condition_reason(), "");
  EXPECT_TRUE(service_.Export(map_, v1::EXPORT_FORMAT_PLY).ok());
  ASSERT_TRUE(UploadAndClose(&service_, other, MakeBatch(1, 2)).ok());
  service_.store().Repair();
  EXPECT_TRUE(Eventually(
      [&] { return service_.GetMap(map_)->state().condition() == v1::MAP_CONDITION_READY; }));
  ASSERT_TRUE(UploadAndClose(&service_, session_, MakeBatch(3, 2)).ok());
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 4U);
}

TEST_F(StoreFaultContract, FailedCommitIsNeverShown) {
  service_.store().FailNextCommit();
  EXPECT_THAT(UploadAndClose(&service_, session_, MakeBatch(1, 2)),
              IsError(StatusCode::kUnavailable, "STORE_READ_ONLY", ""));
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 0U);
  EXPECT_EQ(service_.GetMap(map_)->state().voxels(), 0U);
  // Later uploads are refused at once.
  UploadClient client(&service_);
  EXPECT_THAT(UploadAndClose(&service_, session_, MakeBatch(3, 1)),
              IsError(StatusCode::kUnavailable, "STORE_READ_ONLY", ""));
  // The frames are in the log: a restart with a working disk integrates them.
  service_.store().Repair();
  service_.Restart();
  ASSERT_TRUE(UploadAndClose(&service_, session_, MakeBatch(1, 2)).ok());
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 2U);
}

TEST_F(StoreFaultContract, FullDiskEndsTheUploadAndHeals) {
  service_.store().SetDiskLow(true);
  EXPECT_THAT(UploadAndClose(&service_, session_, MakeBatch(1, 2)),
              IsError(StatusCode::kResourceExhausted, "DISK_LOW", ""));
  service_.store().SetDiskLow(false);
  EXPECT_TRUE(UploadAndClose(&service_, session_, MakeBatch(1, 2)).ok());
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 2U);
}

TEST_F(StoreFaultContract, DamagedMapIsQuarantinedAndOthersServe) {
  const std::string other = service_.CreateMap("yard");
  ASSERT_TRUE(UploadAndClose(&service_, session_, MakeBatch(1, 2)).ok());
  service_.store().DamageMap(service_.store().ListMaps()->front().key);
  service_.Restart();
  EXPECT_EQ(service_.GetMap(map_)->state().condition(), v1::MAP_CONDITION_DAMAGED);
  EXPECT_NE(service_.GetMap(map_)->state().condition_reason(), "");
  UploadClient client(&service_);
  EXPECT_EQ(client.Open(session_).status().code(), StatusCode::kDataLoss);
  EXPECT_EQ(service_.Export(map_, v1::EXPORT_FORMAT_PLY).status().code(), StatusCode::kDataLoss);
  EXPECT_TRUE(service_.GetMap(other).ok());
  // The map can be deleted and created again.
  EXPECT_TRUE(service_.DeleteMap(map_).ok());
  service_.CreateMap("hall");
  EXPECT_TRUE(service_.GetMap(map_).ok());
}

TEST_F(StoreFaultContract, ByteBudgetRefusesFramesOnceItIsExceeded) {
  const UploadSession session{service_.CreateMap("small", /*byte_budget=*/1)};
  ASSERT_TRUE(UploadAndClose(&service_, session, MakeBatch(1, 1)).ok());
  EXPECT_THAT(UploadAndClose(&service_, session, MakeBatch(2, 1)),
              IsError(StatusCode::kResourceExhausted, "MAP_BYTES", ""));
}

TEST_F(StoreFaultContract, NothingIsAcknowledgedOrShownBeforeItIsDurable) {
  std::promise<void> release;
  std::shared_future<void> released = release.get_future().share();
  service_.store().SetWriteHook([released] { released.wait(); });
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_, {v1::ACK_LEVEL_RECEIVED, v1::ACK_LEVEL_DURABLE}).ok());
  ASSERT_TRUE(client.Send(MakeBatch(1, 2)));
  ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_RECEIVED, 2));
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_DURABLE).client_seq(), 0U);
  EXPECT_EQ(service_.GetMap(map_)->state().durable_map_seq(), 0U);
  release.set_value();
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_DURABLE).client_seq(), 2U);
  service_.store().SetWriteHook(nullptr);
}

// The superseded stream's frames are still being appended when the second stream repeats them.
TEST_F(StoreFaultContract, FramesUnderWayThatAreRepeatedCountOnce) {
  std::promise<void> release;
  std::shared_future<void> released = release.get_future().share();
  service_.store().SetWriteHook([released] { released.wait(); });
  UploadClient first(&service_);
  ASSERT_TRUE(first.Open(session_, {v1::ACK_LEVEL_RECEIVED}).ok());
  ASSERT_TRUE(first.Send(MakeBatch(1, 4)));
  ASSERT_TRUE(first.ReadUntil(v1::ACK_LEVEL_RECEIVED, 4));
  UploadClient second(&service_);
  EXPECT_EQ(second.Open(session_)->resume_client_seq(), 0U);
  ASSERT_TRUE(second.Send(MakeBatch(1, 6)));
  release.set_value();
  EXPECT_TRUE(second.Close().ok());
  EXPECT_EQ(service_.GetMap(map_)->state().durable_map_seq(), 6U);
  EXPECT_EQ(ReasonOf(first.Finish()), "UPLOAD_SUPERSEDED");
  service_.store().SetWriteHook(nullptr);
}

}  // namespace
}  // namespace steadymap

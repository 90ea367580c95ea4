// Tests the clients of a map whose folder was replaced by an older copy.

#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/contract/watch_client.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

constexpr char kHall[] = "tenants/test/maps/hall";

class RestoredCopy : public ::testing::Test {
 protected:
  std::unique_ptr<TestService> Start() {
    return std::make_unique<TestService>(Transport::kInProcess,
                                         Store::Open(data_, StoreOptions()).value());
  }

  static void Upload(TestService* service, const std::string& session, std::uint64_t first) {
    const absl::Status status =
        UploadAndClose(service, {kHall, "robot-1", session}, MakeBatch(first, 4));
    ASSERT_TRUE(status.ok()) << status;
  }

  static v1::WatchMapRequest Request() {
    v1::WatchMapRequest request;
    request.set_map(kHall);
    request.set_start(v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
    return request;
  }

  static void Replace(const std::filesystem::path& from, const std::filesystem::path& to) {
    std::filesystem::remove_all(to);
    std::filesystem::copy(from, to, std::filesystem::copy_options::recursive);
  }

  TemporaryFolder folder_;
  const std::filesystem::path data_ = folder_.path() / "data";
  const std::filesystem::path copy_ = folder_.path() / "copy";
};

TEST_F(RestoredCopy, TokenOfTheLostHistoryIsRefusedThoughTheRevisionsMeet) {
  auto service = Start();
  service->CreateMap("hall");
  Upload(service.get(), "a", 1);
  service.reset();
  Replace(data_ / "maps", copy_);
  service = Start();
  Upload(service.get(), "a", 5);
  std::string token;
  {
    const auto stub = v1::WatchService::NewStub(service->channel());
    WatchClient watch(stub.get(), Request());
    const auto step = watch.ReadStep();
    ASSERT_TRUE(step.has_value());
    ASSERT_EQ(step->progress.revision(), 8U);
    token = step->progress.resume_token();
  }
  service.reset();
  Replace(copy_, data_ / "maps");
  service = Start();
  v1::WatchMapRequest resume = Request();
  resume.set_start(v1::WATCH_START_UNSPECIFIED);
  resume.set_resume_token(token);
  const auto stub = v1::WatchService::NewStub(service->channel());
  const auto refused = [](const absl::Status& status) {
    return status.code() == absl::StatusCode::kOutOfRange;
  };
  const absl::Status ahead = WatchClient(stub.get(), resume).End();
  EXPECT_TRUE(refused(ahead)) << ahead;
  // Another history reaches the token's revision, and continues after it.
  Upload(service.get(), "b", 101);
  const absl::Status met = WatchClient(stub.get(), resume).End();
  EXPECT_TRUE(refused(met)) << met;
  Upload(service.get(), "b", 105);
  const absl::Status behind = WatchClient(stub.get(), resume).End();
  EXPECT_TRUE(refused(behind)) << behind;
}

}  // namespace
}  // namespace steadymap

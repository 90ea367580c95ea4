// Tests the log warning for a map of objects that receives frames without labels and instances.

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include "proto/batch_checksum.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/wall_frame.h"

namespace steadymap {
namespace {

/// Counts the warnings of this process that contain a text.
class CountedWarnings final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit CountedWarnings(std::string text) : text_(std::move(text)) {}

  int count() const { return count_; }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string_view line(message.payload.data(), message.payload.size());
    if (message.level == spdlog::level::warn && line.find(text_) != line.npos) ++count_;
  }

  void flush_() override {}

 private:
  const std::string text_;
  std::atomic<int> count_ = 0;
};

class UnlabelledUpload : public ::testing::Test {
 protected:
  void SetUp() override { spdlog::default_logger()->sinks().push_back(warnings_); }

  void TearDown() override { spdlog::default_logger()->sinks().pop_back(); }

  std::string CreateMap(const std::string& id, v1::UpdatePolicy policy) {
    grpc::ClientContext context;
    SetDeadline(&context);
    v1::CreateMapRequest request;
    request.set_parent("tenants/test");
    request.set_map_id(id);
    request.mutable_map()->mutable_config()->set_policy(policy);
    v1::Map map;
    const grpc::Status status = service_.maps().CreateMap(&context, request, &map);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return map.name();
  }

  /// Returns the number of warnings caused by one stream of two batches.
  int CountWarnings(const std::string& map, const WallFrame& wall) {
    const int before = warnings_->count();
    UploadSession session{map};
    session.session = "session-" + std::to_string(++sessions_);
    UploadClient client(&service_);
    EXPECT_TRUE(client.Open(session).ok());
    for (const std::uint64_t first_client_seq : {1U, 3U}) {
      v1::FrameBatch batch;
      batch.set_first_client_seq(first_client_seq);
      for (int i = 0; i < 2; ++i) *batch.add_frames() = MakeWallFrame(wall);
      batch.set_images_crc32c(ImagesCrc32c(batch));
      EXPECT_TRUE(client.Send(batch));
    }
    EXPECT_TRUE(client.Close().ok());
    return warnings_->count() - before;
  }

  const std::shared_ptr<CountedWarnings> warnings_ =
      std::make_shared<CountedWarnings>("neither labels nor instances");
  TestService service_{Transport::kInProcess};
  int sessions_ = 0;
};

TEST_F(UnlabelledUpload, IsWarnedAboutOnceAStreamWhereTheMapNeedsLabels) {
  const std::string map = CreateMap("objects", v1::UPDATE_POLICY_POCD_PAPER);
  EXPECT_EQ(CountWarnings(map, {.with_labels = true}), 0);
  EXPECT_EQ(CountWarnings(map, {.with_labels = false}), 1);
  EXPECT_EQ(CountWarnings(map, {.with_labels = false}), 1);
}

TEST_F(UnlabelledUpload, IsAllThatOtherMapsNeed) {
  for (const auto& [id, policy] : {std::pair("surface", v1::UPDATE_POLICY_STATIC),
                                   std::pair("things", v1::UPDATE_POLICY_POCD)}) {
    const std::string map = CreateMap(id, policy);
    EXPECT_EQ(CountWarnings(map, {.with_labels = false}), 0);
  }
}

}  // namespace
}  // namespace steadymap

// When the session of a robot ends, and that the map decides then what the robot has seen.

#include <chrono>
#include <string>

#include <gtest/gtest.h>

#include "proto/batch_checksum.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/eventually.h"
#include "tests/support/wall_frame.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Eventually;

constexpr int kFrames = 4;

class SessionEnd : public ::testing::Test {
 protected:
  explicit SessionEnd(std::chrono::seconds max_silence = std::chrono::seconds(60))
      : service_{Transport::kInProcess, [max_silence](ServerConfig* config) {
                   config->commit.max_delay = std::chrono::milliseconds(10);
                   config->sessions.max_silence = max_silence;
                 }} {}

  std::string CreateMap(const std::string& id, v1::UpdatePolicy policy) {
    v1::CreateMapRequest request;
    request.set_parent("tenants/test");
    request.set_map_id(id);
    request.mutable_map()->mutable_config()->set_policy(policy);
    v1::Map map;
    EXPECT_TRUE(Call([&](auto* context) {
                  return service_.maps().CreateMap(context, request, &map);
                }).ok());
    return map.name();
  }

  std::uint64_t RevisionOf(const std::string& map) {
    return service_.GetMap(map).value().state().revision();
  }

  /// Returns the number of objects that were created.
  int CountCreated(const std::string& map) {
    v1::ListEventsRequest request;
    request.set_map(map);
    request.add_types(v1::EVENT_TYPE_CREATED);
    v1::ListEventsResponse response;
    EXPECT_TRUE(Call([&](auto* context) {
                  return service_.queries().ListEvents(context, request, &response);
                }).ok());
    return response.events_size();
  }

  /// Uploads the frames of a session and loses the connection.
  void UploadAndCut(const std::string& map) {
    UploadClient client(&service_);
    ASSERT_TRUE(client.Open({map}).ok());
    ASSERT_TRUE(client.Send(MakeBatch(1, kFrames)));
    ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_INTEGRATED, kFrames).has_value());
    client.Cancel();
  }

  /// Opens the session again and closes it without a frame.
  void CloseAgain(const std::string& map) {
    UploadClient client(&service_);
    ASSERT_TRUE(client.Open({map}).ok());
    ASSERT_TRUE(client.Close().ok());
  }

  TestService service_;
};

TEST_F(SessionEnd, ComesWithTheHalfCloseAndIsIntegratedBeforeTheStreamEnds) {
  const std::string map = CreateMap("objects", v1::UPDATE_POLICY_POCD);
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open({map}).ok());
  ASSERT_TRUE(client.Send(MakeBatch(1, kFrames)));
  ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_INTEGRATED, kFrames).has_value());
  EXPECT_EQ(CountCreated(map), 0);
  ASSERT_TRUE(client.Close().ok());
  EXPECT_EQ(CountCreated(map), 1);
  EXPECT_EQ(RevisionOf(map), kFrames + 1U);
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_INTEGRATED).revision(), kFrames + 1U);
}

TEST_F(SessionEnd, IsOneEntryHoweverOftenItIsSent) {
  const std::string map = CreateMap("objects", v1::UPDATE_POLICY_POCD);
  ASSERT_TRUE(UploadAndClose(&service_, {map}, MakeBatch(1, kFrames)).ok());
  for (int i = 0; i < 3; ++i) CloseAgain(map);
  EXPECT_EQ(RevisionOf(map), kFrames + 1U);
}

TEST_F(SessionEnd, DoesNotComeWithALostConnection) {
  const std::string map = CreateMap("objects", v1::UPDATE_POLICY_POCD);
  UploadAndCut(map);
  EXPECT_EQ(RevisionOf(map), kFrames);
  CloseAgain(map);
  EXPECT_EQ(RevisionOf(map), kFrames + 1U);
  EXPECT_EQ(CountCreated(map), 1);
}

TEST_F(SessionEnd, SurvivesARestart) {
  const std::string map = CreateMap("objects", v1::UPDATE_POLICY_POCD);
  ASSERT_TRUE(UploadAndClose(&service_, {map}, MakeBatch(1, kFrames)).ok());
  service_.Restart();
  ASSERT_TRUE(Eventually([&] { return RevisionOf(map) == kFrames + 1U; }));
  EXPECT_EQ(CountCreated(map), 1);
  CloseAgain(map);
  EXPECT_EQ(RevisionOf(map), kFrames + 1U);
}

TEST_F(SessionEnd, IsOfNoUseToAMapOfSurface) {
  const std::string map = CreateMap("surface", v1::UPDATE_POLICY_STATIC);
  ASSERT_TRUE(UploadAndClose(&service_, {map}, MakeBatch(1, kFrames)).ok());
  EXPECT_EQ(RevisionOf(map), kFrames);
}

class SilentRobot : public SessionEnd {
 protected:
  SilentRobot() : SessionEnd(std::chrono::seconds(1)) {}
};

TEST_F(SilentRobot, EndsItsSession) {
  const std::string map = CreateMap("objects", v1::UPDATE_POLICY_POCD);
  UploadAndCut(map);
  ASSERT_TRUE(Eventually([&] { return RevisionOf(map) == kFrames + 1U; }));
  EXPECT_EQ(CountCreated(map), 1);
  CloseAgain(map);
  EXPECT_EQ(RevisionOf(map), kFrames + 1U);
}

}  // namespace
}  // namespace steadymap

#include "client/map/map_change.h"

#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "proto/grpc_status.h"
#include "tests/client/map/fake_map_server.h"

namespace steadymap {
namespace {

/// A map service with one map, its etag and its request ids.
class GuardedMapService final : public v1::MapService::Service {
 public:
  v1::Map map;
  std::vector<v1::UpdateMapRequest> requests;
  int versions = 1;
  std::function<void()> before_update = [] {};
  int answers_to_lose = 0;

  grpc::Status GetMap(grpc::ServerContext*, const v1::GetMapRequest*, v1::Map* answer) override {
    *answer = map;
    answer->set_etag(std::to_string(versions));
    return grpc::Status::OK;
  }

  grpc::Status UpdateMap(grpc::ServerContext*,
                         const v1::UpdateMapRequest* request,
                         v1::Map* answer) override {
    before_update();
    const bool is_repeated =
        !requests.empty() && requests.back().request_id() == request->request_id();
    if (!is_repeated) {
      if (request->map().etag() != std::to_string(versions)) {
        return ToGrpcStatus(MakeError(
            absl::StatusCode::kAborted, reason::kEtagMismatch, "another state", "map.etag"));
      }
      *map.mutable_labels() = request->map().labels();
      ++versions;
    }
    requests.push_back(*request);
    if (answers_to_lose-- > 0) return {grpc::StatusCode::UNAVAILABLE, "connection reset"};
    *answer = map;
    return grpc::Status::OK;
  }
};

class MapChangeTest : public ::testing::Test {
 protected:
  MapChangeTest() {
    service_.map.set_name(kKitchen.ToString());
    (*service_.map.mutable_labels())["old"] = "1";
    options_.sleep = [](std::chrono::milliseconds) {};
  }

  absl::StatusOr<v1::Map> Change(const MapChange& change) {
    return ChangeMap(server_.channels(), kKitchen, change, options_);
  }

  GuardedMapService service_;
  FakeServer server_{&service_};
  MapChangeOptions options_;
};

TEST_F(MapChangeTest, ALostAnswerIsAskedForAgainWithTheSameRequest) {
  service_.answers_to_lose = 2;
  const absl::StatusOr<v1::Map> map = Change({.labels = {{"new", "2"}}});
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->labels_size(), 2);
  ASSERT_EQ(service_.requests.size(), 3U);
  EXPECT_NE(service_.requests[0].request_id(), "");
  EXPECT_LE(service_.requests[0].request_id().size(), 64U);
  EXPECT_EQ(service_.requests[2].request_id(), service_.requests[0].request_id());
  EXPECT_EQ(service_.versions, 2) << "it was changed once";
}

TEST_F(MapChangeTest, AServerThatNeverAnswersIsGivenUp) {
  service_.answers_to_lose = 1'000'000;
  EXPECT_EQ(Change({.labels = {{"new", "2"}}}).status().code(), absl::StatusCode::kUnavailable);
  EXPECT_GE(service_.requests.size(), 2U);
}

TEST_F(MapChangeTest, AChangeOfSomebodyElseInBetweenIsKept) {
  int others = 3;
  service_.before_update = [this, &others] {
    if (others-- <= 0) return;
    (*service_.map.mutable_labels())["theirs-" + std::to_string(others)] = "3";
    ++service_.versions;
  };
  const absl::StatusOr<v1::Map> map = Change({.labels = {{"new", "2"}}, .removed_labels = {"old"}});
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->labels_size(), 4);
  EXPECT_FALSE(map->labels().contains("old"));
}

TEST_F(MapChangeTest, AMapThatNeverRestsEndsTheTrying) {
  service_.before_update = [this] { ++service_.versions; };
  EXPECT_EQ(ReasonOf(Change({.labels = {{"new", "2"}}}).status()), reason::kEtagMismatch);
  EXPECT_TRUE(service_.requests.empty());
}

TEST_F(MapChangeTest, AGivenEtagIsTriedOnce) {
  service_.versions = 7;
  const absl::Status status = Change({.labels = {{"new", "2"}}, .etag = "6"}).status();
  EXPECT_EQ(ReasonOf(status), reason::kEtagMismatch);
  EXPECT_TRUE(Change({.labels = {{"new", "2"}}, .etag = "7"}).ok());
}

TEST_F(MapChangeTest, NothingToChangeIsAnError) {
  EXPECT_EQ(Change({}).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(service_.requests.empty());
}

}  // namespace
}  // namespace steadymap

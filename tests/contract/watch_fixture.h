#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/contract/watch_client.h"
#include "tests/support/default_scale.h"
#include "tests/support/packed_leaf.h"

namespace steadymap {

/// Watch limit of the servers in these tests.
inline constexpr std::size_t kMaxWatches = 30;

/// A server with a map, uploads into it, and watches of it.
class WatchServiceTest : public ::testing::TestWithParam<Transport> {
 protected:
  WatchServiceTest()
      : service_(GetParam(), [](ServerConfig* config) {
          config->commit.max_delay = std::chrono::milliseconds(5);
          config->watch.max_watches = kMaxWatches;
          config->watch.openings_per_second = 100'000;
        }) {}

  v1::WatchMapRequest Request(v1::WatchStart start = v1::WATCH_START_SNAPSHOT_THEN_FOLLOW) const {
    v1::WatchMapRequest request;
    request.set_map(map_);
    request.set_start(start);
    return request;
  }

  v1::WatchMapRequest ResumeBehind(const v1::WatchProgress& progress) const {
    v1::WatchMapRequest request = Request(v1::WATCH_START_UNSPECIFIED);
    request.set_resume_token(progress.resume_token());
    return request;
  }

  std::unique_ptr<WatchClient> Watch(const v1::WatchMapRequest& request) {
    stub_ = v1::WatchService::NewStub(service_.channel());
    return std::make_unique<WatchClient>(stub_.get(), request);
  }

  absl::Status ErrorOf(const v1::WatchMapRequest& request) { return Watch(request)->End(); }

  /// Uploads a few more frames; returns the revision that contains them.
  std::uint64_t Upload(int frames = 4) {
    const auto ack =
        UploadByCall(&service_, {map_}, MakeBatch(uploaded_ + 1, frames), v1::ACK_LEVEL_INTEGRATED);
    EXPECT_TRUE(ack.ok()) << ack.status();
    uploaded_ += static_cast<std::uint64_t>(frames);
    return uploaded_;
  }

  /// Queries the leaves of the whole map.
  std::vector<std::string> LeavesByQuery() {
    v1::GetMapSectionRequest request;
    request.set_map(map_);
    grpc::ClientContext context;
    SetDeadline(&context);
    const auto reader = service_.queries().GetMapSection(&context, request);
    std::vector<std::string> leaves;
    v1::GetMapSectionResponse response;
    while (reader->Read(&response)) {
      for (const v1::PackedLeaf& leaf : response.leaves().leaves()) {
        leaves.push_back(leaf.SerializeAsString());
      }
    }
    EXPECT_TRUE(reader->Finish().ok());
    std::sort(leaves.begin(), leaves.end());
    return leaves;
  }

  TestService service_;
  std::string map_ = service_.CreateMap("hall");
  std::unique_ptr<v1::WatchService::Stub> stub_;
  std::uint64_t uploaded_ = 0;
};

/// Joins the leaves of steps; sorted like `LeavesByQuery`.
class ToldLeaves {
 public:
  void Take(const ToldStep& step) {
    for (const v1::PackedLeaf& leaf : step.Leaves()) {
      v1::PackedLeaf key = leaf;
      key.clear_packed();
      key.clear_is_patch();
      v1::PackedLeaf& known = leaves_[key.SerializeAsString()];
      const auto packed = testing::TakePackedLeaf(leaf, known.packed());
      ASSERT_TRUE(packed.has_value());
      known = key;
      known.set_packed(*packed);
      if (packed->empty()) leaves_.erase(key.SerializeAsString());
      if (leaf.is_patch()) ++patches_;
    }
  }

  std::size_t patches() const { return patches_; }

  std::vector<std::string> All() const {
    std::vector<std::string> all;
    for (const auto& [key, leaf] : leaves_) all.push_back(leaf.SerializeAsString());
    std::sort(all.begin(), all.end());
    return all;
  }

 private:
  std::map<std::string, v1::PackedLeaf> leaves_;
  std::size_t patches_ = 0;
};

}  // namespace steadymap

#pragma once

#include <chrono>
#include <cstdint>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "client/upload/uploader.h"
#include "core/types/error.h"
#include "proto/grpc_status.h"
#include "tests/client/map/fake_map_server.h"
#include "tests/client/upload/fake_ingest_service.h"

namespace steadymap {

/// Returns a frame with a depth image of this size.
inline v1::Frame FrameOfBytes(std::size_t depth_bytes) {
  v1::Frame frame;
  frame.mutable_depth()->set_data(std::string(depth_bytes, 'd'));
  frame.mutable_labels()->set_data("labels");
  return frame;
}

/// Returns all numbers from `first` to `last`.
inline std::vector<std::uint64_t> Sequences(std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> sequences(last - first + 1);
  std::iota(sequences.begin(), sequences.end(), first);
  return sequences;
}

/// Returns the status with which a server's script ends.
inline grpc::Status Failure(absl::StatusCode code, std::string_view reason = {}) {
  return ToGrpcStatus(MakeError(code, reason, "as the script says"));
}

/// An upload to a scripted server. Never waits between streams, and records the requested delays.
struct UploadHarness {
  explicit UploadHarness(std::vector<FakeIngestService::Script> scripts)
      : service(std::move(scripts)) {
    options.robot = "robot-7";
    options.sensor = "left";
    options.session = "session-1";
    options.seed = 5;
    options.sleep = [this](std::chrono::milliseconds delay) { delays.push_back(delay); };
  }

  absl::StatusOr<UploadSummary> Upload(std::size_t frame_count, std::size_t frame_bytes = 100) {
    FrameUploader uploader(server.channels(), kKitchen, options);
    for (std::size_t i = 0; i < frame_count; ++i) {
      const absl::Status status = uploader.Push(FrameOfBytes(frame_bytes));
      if (!status.ok()) return status;
    }
    return uploader.Finish();
  }

  FakeIngestService service;
  FakeServer server{&service};
  UploaderOptions options;
  std::vector<std::chrono::milliseconds> delays;
};

}  // namespace steadymap

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <grpcpp/client_context.h>

#include "tests/contract/test_service.h"

#include "steadymap/v1/watch_service.grpc.pb.h"

namespace steadymap {

/// Content of a watch up to a progress.
struct ToldStep {
  std::optional<v1::WatchCreated> created;
  std::optional<v1::WatchResync> resync;
  std::vector<v1::SnapshotChunk> snapshot;
  std::vector<v1::DeltaFragment> delta;
  std::vector<v1::ObjectEvent> events;
  v1::WatchProgress progress;

  /// States and leaves of the snapshot or the delta, in their order.
  std::vector<v1::Object> Objects() const;
  std::vector<v1::PackedLeaf> Leaves() const;
  std::vector<std::uint64_t> Removed() const;
};

/// One WatchMap stream, read step by step from the test's thread.
class WatchClient {
 public:
  WatchClient(v1::WatchService::StubInterface* stub, const v1::WatchMapRequest& request);

  /// Cancels the stream if it has not ended.
  ~WatchClient();

  /// Reads the next message; none at the end of the stream.
  std::optional<v1::WatchMapResponse> Read();

  /// Reads everything up to the next progress; none if the stream ends before.
  std::optional<ToldStep> ReadStep();

  /// Reads steps until one reaches `revision`, and joins them; none if the stream ends before.
  std::optional<ToldStep> ReadUntil(std::uint64_t revision);

  /// Reads all remaining messages and returns the final status of the stream.
  absl::Status End();

  void Cancel() { context_.TryCancel(); }

  /// True if the server has sent a goodbye.
  bool was_told_goodbye() const { return was_told_goodbye_; }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderInterface<v1::WatchMapResponse>> stream_;
  bool was_told_goodbye_ = false;
  bool ended_ = false;
};

}  // namespace steadymap

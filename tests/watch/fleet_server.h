#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/channel.h>

#include "server/server.h"
#include "tests/support/temporary_folder.h"
#include "tests/watch/recording_store.h"

#include "steadymap/v1/frame.pb.h"
#include "steadymap/v1/map.pb.h"

namespace steadymap {

/// A server over a store on disk with one map, which can be killed and started again, and whose
/// commits are recorded. Thread-safe but for `Kill`, `Compact` and `Upload`, which are for one
/// thread.
class FleetServer {
 public:
  FleetServer();
  ~FleetServer();

  /// Ends the server as a kill would: nothing that is not stored by now ever is. Starts it anew.
  void Kill();

  /// Forgets all change lists but the newest few, whoever needs them.
  void Compact();

  /// Uploads frames of a robot until they are durable, killed servers or not.
  void Upload(const std::string& robot, const std::vector<v1::Frame>& frames);

  /// Waits until everything that was uploaded is committed.
  void AwaitIntegrated();

  /// Where the server that runs now listens, `HOST:PORT`.
  std::string address() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// A new connection to it.
  std::shared_ptr<grpc::Channel> Connect() const ABSL_LOCKS_EXCLUDED(mutex_);

  const std::string& map() const { return map_; }

  const MapHistory& history() const { return history_; }

  VoxelScale scale() const { return {0.05, 0.15}; }

 private:
  void Start();
  v1::Map GetMap() const;
  absl::Status UploadOnce(const std::string& robot,
                          const std::vector<v1::Frame>& frames,
                          std::uint64_t first_client_seq);

  TemporaryFolder folder_;
  MapHistory history_;
  std::atomic<bool> killed_ = false;
  std::string map_ = "tenants/test/maps/hall";
  std::uint64_t uploaded_ = 0;
  RecordingStore* store_ = nullptr;  ///< The server's.
  std::unique_ptr<Server> server_;
  mutable absl::Mutex mutex_;
  int port_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace steadymap

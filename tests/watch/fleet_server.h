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

/// A server with a store on disk and one map, which can be killed and restarted, and whose commits
/// are recorded. Thread-safe except `Kill`, `Compact` and `Upload`, which are for one thread.
class FleetServer {
 public:
  FleetServer();
  ~FleetServer();

  /// Ends the server like a kill: data that is not stored yet is lost. Then restarts it.
  void Kill();

  /// Drops all change lists except the newest few, even if watchers need them.
  void Compact();

  /// Uploads frames of a robot until they are durable, across restarts of the server.
  void Upload(const std::string& robot, const std::vector<v1::Frame>& frames);

  /// Waits until all uploaded frames are committed.
  void AwaitIntegrated();

  /// Address of the running server, `HOST:PORT`.
  std::string address() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Opens a new connection to the running server.
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
  RecordingStore* store_ = nullptr;  ///< Owned by the server.
  std::unique_ptr<Server> server_;
  mutable absl::Mutex mutex_;
  int port_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace steadymap

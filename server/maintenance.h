#pragma once

#include <thread>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "server/config/server_config.h"
#include "server/mapping/map_directory.h"
#include "server/process/heartbeat.h"
#include "server/rpc/stream_limiter.h"
#include "server/store/model/store.h"
#include "server/upload/upload_registry.h"
#include "server/watch/watch_hub.h"

namespace steadymap {

/// Does now and then what no call does: one thread goes through all maps, drops from their logs
/// what is integrated and no longer wanted, at once where the disk is low, forgets upload sessions
/// that have been idle for too long, and ends watches, exports and sections that have stalled.
class Maintenance {
 public:
  /// What the maintenance looks after; all of it outlives it.
  struct Dependencies {
    const MapDirectory* maps = nullptr;
    const UploadRegistry* uploads = nullptr;
    WatchHub* watches = nullptr;
    StreamLimiter* streams = nullptr;
    Store* store = nullptr;
  };

  /// Starts the thread.
  Maintenance(const Dependencies& dependencies, const RetentionOptions& options);

  /// Ends the thread.
  ~Maintenance();

  Maintenance(const Maintenance&) = delete;
  Maintenance& operator=(const Maintenance&) = delete;

  const Heartbeat& heartbeat() const { return heartbeat_; }

 private:
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  void TrimAll(bool disk_is_low);
  bool AwaitStop() ABSL_LOCKS_EXCLUDED(mutex_);

  const Dependencies dependencies_;
  const RetentionOptions options_;
  absl::Mutex mutex_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  Heartbeat heartbeat_;
  std::thread thread_;  ///< Last: it uses everything above.
};

}  // namespace steadymap

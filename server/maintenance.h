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

/// Periodic work on all maps, done by one thread: removes integrated frames that exceed the
/// retention from the logs (immediately if the disk is low), deletes idle upload sessions, ends the
/// sessions of silent robots, and ends watches, exports and section streams that have stalled.
class Maintenance {
 public:
  /// The parts of the server that the maintenance uses. All of them must outlive it.
  struct Dependencies {
    const MapDirectory* maps = nullptr;
    const UploadRegistry* uploads = nullptr;
    WatchHub* watches = nullptr;
    StreamLimiter* streams = nullptr;
    Store* store = nullptr;
  };

  /// Starts the thread.
  Maintenance(const Dependencies& dependencies,
              const RetentionOptions& options,
              const SessionOptions& sessions);

  /// Stops and joins the thread.
  ~Maintenance();

  Maintenance(const Maintenance&) = delete;
  Maintenance& operator=(const Maintenance&) = delete;

  const Heartbeat& heartbeat() const { return heartbeat_; }

 private:
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  void EndSilentSessions();
  void TrimAll(bool disk_is_low);
  bool AwaitStop() ABSL_LOCKS_EXCLUDED(mutex_);

  const Dependencies dependencies_;
  const RetentionOptions options_;
  const SessionOptions sessions_;
  absl::Mutex mutex_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  Heartbeat heartbeat_;
  std::thread thread_;  ///< Declared last because it uses all members above.
};

}  // namespace steadymap

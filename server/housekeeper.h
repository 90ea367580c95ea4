#pragma once

#include <thread>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "server/heartbeat.h"
#include "server/map_directory.h"
#include "server/server_config.h"
#include "server/store.h"
#include "server/stream_gate.h"
#include "server/watch_hub.h"

namespace steadymap {

/// Does now and then what no call does: one thread goes through all maps, drops from their logs
/// what is integrated and no longer wanted, forgets upload sessions that have been idle for too
/// long, and ends watches, exports and sections that have stalled.
class Housekeeper {
 public:
  /// Starts the thread. What it is given must outlive it.
  Housekeeper(const MapDirectory* maps,
              WatchHub* watches,
              StreamGate* streams,
              Store* store,
              const RetentionOptions& options);

  /// Ends the thread.
  ~Housekeeper();

  Housekeeper(const Housekeeper&) = delete;
  Housekeeper& operator=(const Housekeeper&) = delete;

  const Heartbeat& heartbeat() const { return heartbeat_; }

 private:
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  void TrimAll();
  bool AwaitStop() ABSL_LOCKS_EXCLUDED(mutex_);

  const MapDirectory* const maps_;
  WatchHub* const watches_;
  StreamGate* const streams_;
  Store* const store_;
  const RetentionOptions options_;
  absl::Mutex mutex_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  Heartbeat heartbeat_;
  std::thread thread_;  ///< Last: it uses everything above.
};

}  // namespace steadymap

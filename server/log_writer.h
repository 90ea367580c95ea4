#pragma once

#include <functional>
#include <map>
#include <memory>
#include <thread>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "server/heartbeat.h"
#include "server/map_runtime.h"
#include "server/store.h"

namespace steadymap {

/// Makes frames durable: one thread takes what waits in all maps' queues, in turn, gives each frame
/// its place in its map's log, and writes them as one synced batch (group commit). While it syncs,
/// the next group gathers.
///
/// It is also the last to look whether a frame is known already, so that none counts twice however
/// it came here.
class LogWriter {
 public:
  /// Starts the thread. `on_failure` is called from it when the store refuses an append.
  LogWriter(Store* store, std::function<void(const absl::Status&)> on_failure);

  /// Stops as `Stop` does.
  ~LogWriter();

  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// The map's queue has got frames. Any thread.
  void Notify(const std::shared_ptr<MapRuntime>& map) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Writes what waits, then ends the thread. Not from the thread itself.
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);

  const Heartbeat& heartbeat() const { return heartbeat_; }

 private:
  /// What is written of one map at a time.
  struct MapGroup;

  void Run();
  std::vector<MapGroup> TakeGroups() ABSL_LOCKS_EXCLUDED(mutex_);
  void Write(std::vector<MapGroup> groups);
  static void Finish(MapGroup* group, const absl::Status& status);

  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stopping_ || !ready_.empty();
  }

  Store* const store_;
  const std::function<void(const absl::Status&)> on_failure_;
  absl::Mutex mutex_;
  /// Maps whose queues may hold frames, in the order of their keys.
  std::map<MapKey, std::shared_ptr<MapRuntime>> ready_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  Heartbeat heartbeat_;
  std::thread thread_;  ///< Last: it uses everything above.
};

}  // namespace steadymap

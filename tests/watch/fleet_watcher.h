#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/client_context.h>

#include "core/map/map_filter.h"
#include "tests/watch/fleet_server.h"
#include "tests/watch/watch_promises.h"

namespace steadymap {

/// Results of a watcher.
struct WatchLife {
  std::vector<std::string> broken;  ///< Broken promises, and unexpected errors.
  std::size_t streams = 0;
  std::size_t resumed = 0;
  std::size_t steps = 0;
  std::size_t jumps = 0;
  std::size_t patches = 0;
  std::size_t continued = 0;  ///< Streams that continued a step.
  std::size_t events = 0;
  std::size_t resyncs = 0;
  std::size_t gaps_told = 0;  ///< Streams that ended because their history was compacted.
};

/// A watcher with its own thread that reads and checks, reconnects after a broken stream, and can
/// be made to misbehave. The other functions are for one thread.
class FleetWatcher {
 public:
  /// `server` must outlive the watcher.
  FleetWatcher(const FleetServer* server, std::uint32_t seed);

  /// Stops at once.
  ~FleetWatcher();

  /// Breaks the connection; the watcher resumes.
  void Cut();

  /// Stops reading until `Resume`.
  void Stall();
  void Resume();

  /// Restarts with another filter, from a snapshot or from now on.
  void ChangeMind();

  /// Revision of the last progress.
  Revision revision() const { return Revision(revision_.load()); }

  /// Stops the watch permanently and returns its results.
  WatchLife Stop();

 private:
  void Run();
  void RunStream();
  void Conclude();
  void NewMind() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  bool MayRead() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !stalled_ || stopping_; }

  const FleetServer* const server_;
  std::mt19937 random_;  ///< Used by the holder of `mutex_`.
  std::atomic<std::uint64_t> revision_ = 0;

  // Used by the thread only.
  std::unique_ptr<WatchPromises> promises_;
  WatchPromises::Begin begin_ = WatchPromises::Begin::kSnapshot;
  WatchLife life_;

  mutable absl::Mutex mutex_;
  MapFilter filter_ ABSL_GUARDED_BY(mutex_);
  bool from_now_ ABSL_GUARDED_BY(mutex_) = false;
  bool resyncs_ ABSL_GUARDED_BY(mutex_) = false;
  bool takes_patches_ ABSL_GUARDED_BY(mutex_) = false;
  bool keeps_parts_ ABSL_GUARDED_BY(mutex_) = false;  ///< Of interrupted steps.
  bool changed_mind_ ABSL_GUARDED_BY(mutex_) = true;
  bool stalled_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  grpc::ClientContext* context_ ABSL_GUARDED_BY(mutex_) = nullptr;  ///< Of the running stream.

  std::thread thread_;  ///< Last member: it uses all members above.
};

}  // namespace steadymap

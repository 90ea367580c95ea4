#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "client/map/map_mirror.h"
#include "core/map/map_filter.h"
#include "tests/support/tcp_proxy.h"
#include "tests/watch/fleet_server.h"
#include "tests/watch/map_history.h"

namespace steadymap {

/// What a mirror showed in its life.
struct MirrorLife {
  std::vector<std::string> broken;  ///< What it showed that the map did not hold.
  std::size_t steps = 0;
  std::size_t snapshots = 0;      ///< Of those, the ones that replaced everything.
  std::size_t reconnections = 0;  ///< Tries after a stream had broken off.
};

/// A `MapMirror` behind a network of its own that can be made worse, held to what the map held:
/// whatever it shows must be the map at that revision, bit for bit, with the events in between. For
/// one thread.
class FleetMirror {
 public:
  /// `server` outlives the mirror. The filter is drawn from the seed.
  FleetMirror(const FleetServer* server, std::uint32_t seed);

  /// To be called when the server listens elsewhere.
  void FollowServer() { proxy_.SetTarget(server_->address()); }

  /// Resets its connections.
  void Cut() { proxy_.Cut(); }

  /// Nothing moves until `Resume`.
  void Stall() { proxy_.Stall(); }

  /// Little moves until `Resume`: a snapshot takes seconds.
  void Throttle() { proxy_.Throttle(kThrottledBytesPerSecond); }

  void Resume() {
    proxy_.Throttle(0);
    proxy_.Resume();
  }

  Revision revision() const { return mirror_->revision(); }

  /// Ends the mirror, which is of no use any more.
  MirrorLife Stop() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  static constexpr std::size_t kThrottledBytesPerSecond = 20'000;

  void Check(const MirrorStep& step) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CheckEvents(const MirrorStep& step) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const FleetServer* const server_;
  const MapFilter filter_;
  TcpProxy proxy_;

  absl::Mutex mutex_;
  MapReplay replay_ ABSL_GUARDED_BY(mutex_);
  MirrorLife life_ ABSL_GUARDED_BY(mutex_);

  std::unique_ptr<MapMirror> mirror_;  ///< Last: its thread uses everything above.
};

}  // namespace steadymap

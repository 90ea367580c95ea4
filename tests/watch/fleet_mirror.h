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

/// Results of a mirror.
struct MirrorLife {
  std::vector<std::string> broken;  ///< Differences between the mirror and the map.
  std::size_t steps = 0;
  std::size_t snapshots = 0;      ///< Steps that replaced the whole map.
  std::size_t reconnections = 0;  ///< Attempts after a broken stream.
};

/// A `MapMirror` behind its own faulty network, compared with the history of the map: every
/// revision that it shows must equal the map at that revision, bit for bit, with the events in
/// between. For one thread.
class FleetMirror {
 public:
  /// `server` must outlive the mirror. The filter is drawn from the seed.
  FleetMirror(const FleetServer* server, std::uint32_t seed);

  /// Call when the server listens at a new address.
  void FollowServer() { proxy_.SetTarget(server_->address()); }

  /// Resets its connections.
  void Cut() { proxy_.Cut(); }

  /// Stops all traffic until `Resume`.
  void Stall() { proxy_.Stall(); }

  /// Slows the traffic until `Resume`: a snapshot takes seconds.
  void Throttle() { proxy_.Throttle(kThrottledBytesPerSecond); }

  void Resume() {
    proxy_.Throttle(0);
    proxy_.Resume();
  }

  Revision revision() const { return mirror_->revision(); }

  /// Stops the mirror permanently and returns its results.
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

  std::unique_ptr<MapMirror> mirror_;  ///< Last member: its thread uses all members above.
};

}  // namespace steadymap

#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <absl/status/status.h>

#include "client/map/map_client.h"
#include "client/map/mirror_step.h"
#include "client/transport/channel.h"
#include "client/watch/map_watch.h"
#include "core/map/map_snapshot.h"
#include "core/query/map_sampler.h"
#include "core/types/identifiers.h"

namespace steadymap {

/// Options of a mirror, those of its watch.
using MirrorOptions = WatchOptions;

/// Callbacks of a mirror, called from its thread, one call at a time, without locks held; each may
/// be empty. They may call every function of the mirror, but must not destroy it. A running
/// callback delays all messages; the server ends a watch that makes no progress for too long.
struct MirrorCallbacks {
  /// The mirror shows a new revision.
  std::function<void(const MirrorStep&)> on_step;

  /// The events of a step, after `on_step`. Not called for a step without events.
  std::function<void(std::span<const NumberedEvent>)> on_events;

  std::function<void(const WatchStateChange&)> on_state;
};

/// A local copy of a server's map, or of the part selected by a filter, kept up to date in this
/// process.
///
/// The copy always shows one complete revision: at revision R the mirror holds the leaves, bit for
/// bit, and the objects of the server's map at R that pass the filter. A new revision becomes
/// visible once it has arrived completely. The mirror survives broken connections and server
/// restarts and resumes after its last revision. Received content is validated; invalid content
/// never becomes visible, and a new snapshot follows.
///
/// A mirror started with `kNow`, or with a token of another mirror, holds only the changes since
/// then. Its objects contain the fields of the wire format: no evidence of single leaves and no
/// `in_place_since`.
///
/// Runs one thread. All functions are thread-safe. The cost of a step is proportional to its
/// changes.
class MapMirror {
 public:
  /// Starts the mirror. Errors are reported by `status` and `on_state`. Each stream uses a new
  /// channel from `open_channel`.
  static std::unique_ptr<MapMirror> Start(ChannelOpener open_channel,
                                          const MapName& map,
                                          const MirrorOptions& options = {},
                                          const MirrorCallbacks& callbacks = {});

  /// Stops the mirror; waits for a running callback.
  ~MapMirror();

  MapMirror(const MapMirror&) = delete;
  MapMirror& operator=(const MapMirror&) = delete;

  /// Returns the map at the newest complete revision; empty, at revision 0, before the first. Never
  /// null; the returned map is immutable.
  std::shared_ptr<const MapSnapshot> snapshot() const;

  /// Revision of `snapshot()`.
  Revision revision() const { return snapshot()->revision; }

  /// Token with which another watch with an equal filter can resume after the newest complete
  /// revision; empty before the first.
  std::string resume_token() const;

  /// OK while the mirror follows its map or reconnects; afterwards the error that ended it.
  absl::Status status() const;

  /// Waits until the mirror shows `revision` or a newer one. Errors: `DeadlineExceeded`; the error
  /// that ended the mirror.
  absl::Status AwaitRevision(Revision revision, std::chrono::milliseconds timeout) const;

  /// Samples the map at each point (world frame, metres), all at one revision. A mirror holds no
  /// observed free space: points and rays are free only within the truncation band of a surface.
  std::vector<MapDistance> SampleDistance(std::span<const Eigen::Vector3d> points_world) const;

  /// Casts each ray to the first surface and returns the length of its free part, all at one
  /// revision. A ray with a zero or non-finite direction hits nothing.
  std::vector<MapRayHit> CastRays(std::span<const WorldRay> rays, double max_range_m) const;

  /// Returns the objects in ascending order of id, including archived ones that pass the filter.
  std::vector<std::shared_ptr<const MapObject>> Objects() const;

 private:
  class Follower;

  MapMirror(ChannelOpener open_channel,
            const MapName& map,
            const MirrorOptions& options,
            const MirrorCallbacks& callbacks);

  std::unique_ptr<Follower> follower_;
  std::unique_ptr<MapWatch> watch_;  ///< Last member: its thread uses the follower.
};

}  // namespace steadymap

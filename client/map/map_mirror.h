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

/// How a mirror follows its map.
using MirrorOptions = WatchOptions;

/// Whom a mirror tells of what it does. Called from its thread, one call at a time, without locks
/// held; each may be empty. They may ask the mirror anything, but not destroy it; while one runs
/// nothing arrives, and a server drops a watcher that stands still for long.
struct MirrorCallbacks {
  /// The mirror shows another revision.
  std::function<void(const MirrorStep&)> on_step;

  /// What happened in a step, after `on_step` and only where anything did.
  std::function<void(std::span<const NumberedEvent>)> on_events;

  std::function<void(const WatchStateChange&)> on_state;
};

/// A map of a server, or what a filter shows of it, kept up to date in this process.
///
/// What it shows is always one whole revision: at revision R the mirror holds the leaves, bit for
/// bit, and the objects that the server's map holds at R and the filter lets pass. A new revision
/// appears once all of it has arrived. Broken connections and server restarts are survived; the
/// mirror goes on where it was. What arrives is checked; what makes no sense never becomes visible
/// and is followed by a fresh snapshot.
///
/// A mirror that starts with `kNow`, or behind a token of another one, holds what has changed
/// since. Of an object it has what the wire has: no evidence of single leaves, and no
/// `in_place_since`.
///
/// Runs one thread. All functions are thread-safe. A step costs what it changes.
class MapMirror {
 public:
  /// Starts; what goes wrong shows in `status` and `on_state`. Each stream has a channel of its own
  /// from `open_channel`.
  static std::unique_ptr<MapMirror> Start(ChannelOpener open_channel,
                                          const MapName& map,
                                          const MirrorOptions& options = {},
                                          const MirrorCallbacks& callbacks = {});

  /// Stops; returns once the callback that runs, if any, has returned.
  ~MapMirror();

  MapMirror(const MapMirror&) = delete;
  MapMirror& operator=(const MapMirror&) = delete;

  /// The map at the newest revision that is whole; empty, at revision 0, before the first. Never
  /// null, and never changes.
  std::shared_ptr<const MapSnapshot> snapshot() const;

  /// That revision.
  Revision revision() const { return snapshot()->revision; }

  /// Where another watch with the same filter can go on behind the newest whole revision; empty
  /// before the first.
  std::string resume_token() const;

  /// OK as long as the mirror follows its map or tries to; afterwards why it ended.
  absl::Status status() const;

  /// Waits until the mirror shows `revision` or a newer one. Errors: `DeadlineExceeded`; what the
  /// mirror ended with.
  absl::Status AwaitRevision(Revision revision, std::chrono::milliseconds timeout) const;

  /// The map at each point (world frame, metres), all of one revision. A mirror holds no space that
  /// was looked through: points and rays are free within the truncation of a surface alone.
  std::vector<MapDistance> SampleDistance(std::span<const Eigen::Vector3d> points_world) const;

  /// The first surface along each ray, and how far it is free, all of one revision. A direction of
  /// zero, or one that is not finite, meets none.
  std::vector<MapRayHit> CastRays(std::span<const WorldRay> rays, double max_range_m) const;

  /// The objects by rising id, archived ones included where the filter lets them pass.
  std::vector<std::shared_ptr<const MapObject>> Objects() const;

 private:
  class Follower;

  MapMirror(ChannelOpener open_channel,
            const MapName& map,
            const MirrorOptions& options,
            const MirrorCallbacks& callbacks);

  std::unique_ptr<Follower> follower_;
  std::unique_ptr<MapWatch> watch_;  ///< Last: its thread uses the follower.
};

}  // namespace steadymap

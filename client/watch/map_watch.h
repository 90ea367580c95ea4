#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/client_context.h>

#include "client/transport/backoff.h"
#include "client/transport/channel.h"
#include "client/watch/watch_consumer.h"
#include "client/watch/watch_sequence.h"
#include "core/map/map_filter.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/watch_service.grpc.pb.h"

namespace steadymap {

/// How a map is watched.
struct WatchOptions {
  MapFilter filter;  ///< At least one kind must be wanted.

  /// How the first stream begins; `kResume`: behind `resume_token`, which was given to the same
  /// filter.
  WatchOpening start = WatchOpening::kSnapshot;
  std::string resume_token;

  /// Where going on is not possible (the history behind the token is gone, or what arrived made no
  /// sense), take a snapshot in place of what is there. Otherwise the watch ends.
  bool resync_if_compacted = true;

  /// Whether deltas may bring patches of leaves, for consumers that keep all leaves they get; not
  /// with `kNow`. A mirror decides that itself.
  bool takes_patches = false;

  /// Messages are not larger, in [65536, 4194304]; 0: as the server likes.
  std::uint32_t max_message_bytes = 0;

  /// Waits between reconnections. A watch goes on until its owner ends it, if not told otherwise.
  BackoffOptions backoff = {.give_up_after = std::chrono::milliseconds::max()};

  /// Seed of the jitter. 0: from the system's random device.
  std::uint64_t seed = 0;

  /// Replaces the waiting between reconnections, and the clock: tries then take no time. For tests.
  /// Empty: really waits.
  std::function<void(std::chrono::milliseconds)> sleep;
};

/// Follows a map as it changes, over any number of streams: what breaks and may heal is opened
/// again, with backoff and jitter, behind the last whole step or, of a long one, behind what has
/// come of it. What arrives is checked and handed to a consumer, which sees each step once and
/// whole.
///
/// Runs one thread.
class MapWatch {
 public:
  /// Starts. Each stream has a channel of its own from `open_channel`. `consumer` must outlive the
  /// watch.
  MapWatch(ChannelOpener open_channel,
           const MapName& map,
           WatchOptions options,
           WatchConsumer* consumer);

  /// Stops at once, whatever is under way but for calls to the consumer, which it waits for. Not
  /// to be called from one of those.
  ~MapWatch();

  MapWatch(const MapWatch&) = delete;
  MapWatch& operator=(const MapWatch&) = delete;

 private:
  /// How a stream ended.
  struct StreamEnd {
    absl::Status status;          ///< As the server or gRPC says.
    absl::Status violation;       ///< What the server did wrong; OK if nothing.
    bool was_created = false;     ///< Whether the server let the watch begin.
    bool has_progressed = false;  ///< Whether any step was whole that brought something.
    std::chrono::milliseconds took{0};
  };

  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  StreamEnd RunStream(WatchOpening opening) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Take(const v1::WatchMapResponse& message);
  absl::Status TakeCreated(const v1::WatchCreated& created);
  void Commit();

  absl::Status CheckOptions() const;
  v1::WatchMapRequest RequestFor(WatchOpening opening) const;
  std::optional<WatchOpening> NextOpening(const StreamEnd& end, WatchOpening last);
  FailedTry DescribeFailure(const StreamEnd& end) const;
  bool WaitBeforeRetry(const absl::Status& status, const FailedTry& failed, Backoff* backoff)
      ABSL_LOCKS_EXCLUDED(mutex_);

  bool BeginStream(grpc::ClientContext* context) ABSL_LOCKS_EXCLUDED(mutex_);
  void EndStream() ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsStopped() const ABSL_LOCKS_EXCLUDED(mutex_);

  const std::string map_;
  const WatchOptions options_;
  const ChannelOpener open_channel_;
  WatchConsumer* const consumer_;

  // Of the thread alone.
  WatchSequence sequence_;
  absl::Status
      resync_reason_;  ///< Why a snapshot is on its way; OK if it was asked for, or none is.

  mutable absl::Mutex mutex_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  grpc::ClientContext* context_ ABSL_GUARDED_BY(mutex_) = nullptr;  ///< Of the open stream.

  std::thread thread_;  ///< Last: it uses everything above.
};

}  // namespace steadymap

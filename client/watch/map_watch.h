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

/// Options of a watch.
struct WatchOptions {
  MapFilter filter;  ///< Must select at least one of events, states and volumes.

  /// Start of the first stream. `kResume`: continues after `resume_token`, which must come from a
  /// watch with an equal filter.
  WatchOpening start = WatchOpening::kSnapshot;
  std::string resume_token;

  /// If true and resuming is impossible (the history after the token was compacted, or the server
  /// sent invalid content), the watch continues with a snapshot that replaces the consumer's state.
  /// If false, the watch ends.
  bool resync_if_compacted = true;

  /// True if deltas may contain leaf patches. For consumers that keep every received leaf; invalid
  /// with `kNow`. `MapMirror` sets it itself.
  bool takes_patches = false;

  /// Upper limit of the message size, in [65536, 4194304]; 0: the server's default.
  std::uint32_t max_message_bytes = 0;

  /// Delays between reconnections. By default a watch retries until its owner ends it.
  BackoffOptions backoff = {.give_up_after = std::chrono::milliseconds::max()};

  /// Seed of the jitter. 0: from the system's random device.
  std::uint64_t seed = 0;

  /// Replaces the wait between reconnections and the clock; attempts then take no time. For tests.
  /// Empty: waits in real time.
  std::function<void(std::chrono::milliseconds)> sleep;
};

/// Watches the changes of a map over any number of streams. After a transient error it opens a new
/// stream with backoff and jitter, which resumes after the last complete step or, in a long step,
/// after the received part of it. Validates every message and passes it to a consumer, which
/// receives each step completely and exactly once.
///
/// Runs one thread.
class MapWatch {
 public:
  /// Starts the watch. Each stream uses a new channel from `open_channel`. `consumer` must outlive
  /// the watch.
  MapWatch(ChannelOpener open_channel,
           const MapName& map,
           WatchOptions options,
           WatchConsumer* consumer);

  /// Cancels the stream and joins the thread; waits for a running call of the consumer. Must not be
  /// called from a consumer callback.
  ~MapWatch();

  MapWatch(const MapWatch&) = delete;
  MapWatch& operator=(const MapWatch&) = delete;

 private:
  /// Result of a stream.
  struct StreamEnd {
    absl::Status status;          ///< From the server or gRPC.
    absl::Status violation;       ///< Protocol violation of the server; OK if none.
    bool was_created = false;     ///< The server has accepted the watch.
    bool has_progressed = false;  ///< At least one step with changes was completed.
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

  // Used by the thread only.
  WatchSequence sequence_;
  absl::Status resync_reason_;  ///< Of a running resync; else OK.

  mutable absl::Mutex mutex_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  grpc::ClientContext* context_ ABSL_GUARDED_BY(mutex_) = nullptr;  ///< Of the open stream.

  std::thread thread_;  ///< Last member: it uses all members above.
};

}  // namespace steadymap

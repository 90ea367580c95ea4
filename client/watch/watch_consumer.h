#pragma once

#include <chrono>

#include <absl/status/status.h>

#include "client/watch/watch_sequence.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// State of a watch.
enum class WatchState {
  kConnected,     ///< A stream is open.
  kReconnecting,  ///< The stream broke; a retry follows.
  kResynced,      ///< Resuming was impossible; a snapshot replaced the state.
  kEnded,         ///< The watch has ended permanently.
};

/// A change of the state of a watch.
struct WatchStateChange {
  WatchState state = WatchState::kConnected;
  absl::Status status;                 ///< Reason; OK for `kConnected`.
  std::chrono::milliseconds delay{0};  ///< Until the next attempt, if any.
};

/// Receives the content of a watch after validation by `WatchSequence`. Called from the watch's
/// thread, one call at a time, without locks held. A call must not destroy the watch.
///
/// An error return marks the content as invalid; the watch handles it as a protocol violation.
class WatchConsumer {
 public:
  virtual ~WatchConsumer() = default;

  /// A stream is open. With `kResume` it continues after the last step. With `kNow` the consumer
  /// starts with an empty state; with `kSnapshot` it starts with the snapshot that follows. Not
  /// called for a stream that continues an unfinished step.
  virtual absl::Status Begin(const v1::WatchCreated& created, WatchOpening opening) = 0;

  /// A snapshot follows that replaces the whole state.
  virtual absl::Status Resync(const v1::WatchResync& resync) = 0;

  /// Parts of the current step. They may arrive over several streams.
  virtual absl::Status TakeSnapshot(const v1::SnapshotChunk& chunk) = 0;
  virtual absl::Status TakeDelta(const v1::DeltaFragment& delta) = 0;
  virtual absl::Status TakeEvents(const v1::EventBatch& batch) = 0;

  /// The current step is complete.
  virtual void Commit(const WatchStep& step) = 0;

  /// The current step will not be completed: drop its parts. No effect without parts.
  virtual void Discard() = 0;

  virtual void OnState(const WatchStateChange& change) = 0;
};

}  // namespace steadymap

#pragma once

#include <chrono>

#include <absl/status/status.h>

#include "client/watch/watch_sequence.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// What becomes of a watch.
enum class WatchState {
  kConnected,     ///< A stream is open.
  kReconnecting,  ///< It broke off; another try follows.
  kResynced,      ///< A snapshot took the place of everything, since going on was not possible.
  kEnded,         ///< For good.
};

/// One change of it.
struct WatchStateChange {
  WatchState state = WatchState::kConnected;
  absl::Status status;                 ///< Why; OK where it is connected.
  std::chrono::milliseconds delay{0};  ///< Until the next try, where one follows.
};

/// Takes what a watch brings, checked as `WatchSequence` does. Called from the watch's thread, one
/// call at a time, without locks held. A call must not destroy the watch.
///
/// An error says that the content makes no sense; it is handled as a broken protocol.
class WatchConsumer {
 public:
  virtual ~WatchConsumer() = default;

  /// A stream is open. With `kResume` it goes on behind the last step; with `kNow` the watcher
  /// begins anew with nothing, with `kSnapshot` with the snapshot that follows. Not called for a
  /// stream that goes on within the step on its way.
  virtual absl::Status Begin(const v1::WatchCreated& created, WatchOpening opening) = 0;

  /// A snapshot follows that takes the place of everything.
  virtual absl::Status Resync(const v1::WatchResync& resync) = 0;

  /// Parts of the step that is on its way, over several streams if one breaks off within it.
  virtual absl::Status TakeSnapshot(const v1::SnapshotChunk& chunk) = 0;
  virtual absl::Status TakeDelta(const v1::DeltaFragment& delta) = 0;
  virtual absl::Status TakeEvents(const v1::EventBatch& batch) = 0;

  /// The step is whole.
  virtual void Commit(const WatchStep& step) = 0;

  /// The step will never be whole: its parts must be forgotten. No harm without any.
  virtual void Discard() = 0;

  virtual void OnState(const WatchStateChange& change) = 0;
};

}  // namespace steadymap

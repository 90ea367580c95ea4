#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include "core/mapper.h"
#include "server/frame_budget.h"
#include "server/heartbeat.h"
#include "server/server_config.h"
#include "server/store.h"

namespace steadymap {

/// A durable frame on its way into the map.
struct LoggedFrame {
  MapSequence sequence;
  Frame frame;
  FrameBudget::Reservation reservation;
};

/// The one writer of a map: integrates durable frames in the order of their sequence numbers, and
/// from time to time commits: first to the store, then, when that is synced, to everybody. Frames
/// that are in the log but not in the map when it starts come first.
///
/// A commit happens after `CommitOptions::max_frames` frames, `max_delay` after its first frame, or
/// as soon as a `RequestCommit` can be met. If one fails, the thread ends: nothing that is not
/// stored is ever shown.
class MappingThread {
 public:
  /// What the thread tells its map, from the thread, without locks held.
  struct Listener {
    std::function<void(std::shared_ptr<const MapSnapshot>)> on_commit;  ///< It is stored.
    std::function<void(const absl::Status&)> on_failure;                ///< The last word.
  };

  /// What a map and its thread know of each other.
  struct Source {
    MapRecord record;      ///< Its key and configuration.
    MapSnapshot snapshot;  ///< The stored state.
    MapSequence log_head;  ///< Newest frame in the log; those up to it are read from there.
  };

  /// Starts the thread. `store` and what `listener` refers to must outlive it.
  MappingThread(Source source,
                std::unique_ptr<Mapper> mapper,
                Store* store,
                const CommitOptions& options,
                Listener listener);

  /// Stops without a last commit.
  ~MappingThread();

  MappingThread(const MappingThread&) = delete;
  MappingThread& operator=(const MappingThread&) = delete;

  /// Appends frames; their sequence numbers follow the log's head. Bounded by the budget of which
  /// each frame holds a part. Dropped after a failure. Any thread, one at a time.
  void Push(std::vector<LoggedFrame> frames) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Commits without delay once the frame `target` is integrated. Any thread.
  void RequestCommit(MapSequence target) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Changes `CommitOptions::max_delay` for revisions that begin from now on. Any thread.
  void SetMaxDelay(std::chrono::milliseconds max_delay) { max_delay_ms_ = max_delay.count(); }

  /// Ends the thread after the frame at hand; what is integrated is committed if `commit`. Not from
  /// the thread itself.
  void Stop(bool commit) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Frames that wait for integration, those of the log at the start not included. Any thread.
  std::size_t waiting_frames() const ABSL_LOCKS_EXCLUDED(mutex_);

  const Heartbeat& heartbeat() const { return heartbeat_; }

  /// Whether the thread has ended, after a failure or `Stop`. Any thread.
  bool ended() const { return ended_.load(); }

 private:
  enum class StopMode { kRun, kCommit, kDrop };

  void Run();
  absl::Status IntegrateLog();
  absl::Status IntegrateInbox();
  absl::Status IntegrateOne(MapSequence sequence, const Frame& frame);
  absl::Status CommitIfDue();
  absl::Status Commit();
  std::vector<LoggedFrame> TakeFrames() ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsCommitDue() ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsRequested() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  StopMode stop_mode() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Of the thread alone, once it runs.
  const Source source_;
  const std::unique_ptr<Mapper> mapper_;
  Store* const store_;
  const CommitOptions options_;
  const Listener listener_;
  Heartbeat::Clock::time_point commit_due_ = Heartbeat::Clock::time_point::max();

  mutable absl::Mutex mutex_;
  std::deque<LoggedFrame> inbox_ ABSL_GUARDED_BY(mutex_);
  StopMode stop_mode_ ABSL_GUARDED_BY(mutex_) = StopMode::kRun;
  bool failed_ ABSL_GUARDED_BY(mutex_) = false;
  MapSequence requested_ ABSL_GUARDED_BY(mutex_);   ///< Commit at once when integrated.
  MapSequence integrated_ ABSL_GUARDED_BY(mutex_);  ///< The mapper's head.
  MapSequence committed_ ABSL_GUARDED_BY(mutex_);

  std::atomic<std::chrono::milliseconds::rep> max_delay_ms_;
  Heartbeat heartbeat_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;  ///< Last: it uses everything above.
};

}  // namespace steadymap

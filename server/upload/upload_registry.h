#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include "core/types/identifiers.h"
#include "server/config/server_config.h"
#include "server/store/model/store.h"

namespace steadymap {

/// An upload that others may have to end. Called from any thread, without locks held.
class ActiveUpload {
 public:
  virtual ~ActiveUpload() = default;

  /// Ends at once with `status`.
  virtual void End(const absl::Status& status) = 0;

  /// Takes nothing more, and ends with `status` when what it took is integrated and acknowledged.
  virtual void Drain(const absl::Status& status) = 0;
};

/// All uploads under way. Sees to it that a sensor has one stream a map, that there are not too
/// many, and lets the server drain. Thread-safe.
class UploadRegistry {
 public:
  explicit UploadRegistry(std::size_t max_streams) : max_streams_(max_streams) {}

  /// Enters a sensor's stream; the one before it on the same map, whose place it takes, ends with
  /// `UPLOAD_SUPERSEDED`. Errors: `Unavailable` with reason `DRAINING`; `ResourceExhausted` with
  /// reason `QUEUE_FULL` and a delay for the next try if there are too many.
  absl::Status Enter(MapKey map, const SessionName& session, std::shared_ptr<ActiveUpload> upload)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Takes a stream off the list, if it is still on it.
  void Leave(MapKey map, const SessionName& session, const ActiveUpload* upload)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Counts a call that uploads without a stream. Errors: `Unavailable` with reason `DRAINING`;
  /// `ResourceExhausted` with reason `QUEUE_FULL` if there are too many.
  absl::Status EnterCall() ABSL_LOCKS_EXCLUDED(mutex_);
  void LeaveCall() ABSL_LOCKS_EXCLUDED(mutex_);

  /// The sessions that streams of a map upload in.
  std::set<SessionName> SessionsOf(MapKey map) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends the streams of a map.
  void EndMap(MapKey map, const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Lets nobody in from now on, and asks all streams to come to an end.
  void Drain() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Whether all uploads have ended by `deadline`.
  bool AwaitEmpty(absl::Time deadline) ABSL_LOCKS_EXCLUDED(mutex_);

  /// The bound for streams from now on; those under way go on.
  void SetMaxStreams(std::size_t max_streams) ABSL_LOCKS_EXCLUDED(mutex_);

  std::size_t stream_count() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  using Key = std::pair<MapKey, SensorName>;

  bool IsEmpty() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return streams_.empty() && superseded_ == 0 && calls_ == 0;
  }

  /// A stream under way.
  struct Stream {
    SessionName session;
    std::shared_ptr<ActiveUpload> upload;
  };

  mutable absl::Mutex mutex_;
  std::size_t max_streams_ ABSL_GUARDED_BY(mutex_);
  std::map<Key, Stream> streams_ ABSL_GUARDED_BY(mutex_);
  std::size_t superseded_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Replaced, but not left yet.
  std::size_t calls_ ABSL_GUARDED_BY(mutex_) = 0;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
};

/// The streams that `limits` allow at once.
std::size_t MaxUploadStreams(const LimitOptions& limits);

/// The error that a draining server answers uploads with.
absl::Status DrainingError();

}  // namespace steadymap

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

/// An upload that the server can end. Called from any thread, without locks held.
class ActiveUpload {
 public:
  virtual ~ActiveUpload() = default;

  /// Ends the upload immediately with `status`.
  virtual void End(const absl::Status& status) = 0;

  /// Accepts no more frames; ends with `status` after the accepted frames are integrated and
  /// acknowledged.
  virtual void Drain(const absl::Status& status) = 0;
};

/// All open uploads. Allows one stream per sensor and map, limits their number, and drains them at
/// shutdown. Thread-safe.
class UploadRegistry {
 public:
  explicit UploadRegistry(std::size_t max_streams) : max_streams_(max_streams) {}

  /// Adds a sensor's stream. It replaces the sensor's previous stream to the same map, which ends
  /// with `UPLOAD_SUPERSEDED`. Errors: `Unavailable` with reason `DRAINING`; `ResourceExhausted`
  /// with reason `QUEUE_FULL` and a retry delay if there are too many streams.
  absl::Status Enter(MapKey map, const SessionName& session, std::shared_ptr<ActiveUpload> upload)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Removes a stream, including one that was replaced.
  void Leave(MapKey map, const SessionName& session, const ActiveUpload* upload)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Counts a unary upload call. Errors: `Unavailable` with reason `DRAINING`; `ResourceExhausted`
  /// with reason `QUEUE_FULL` if there are too many calls.
  absl::Status EnterCall() ABSL_LOCKS_EXCLUDED(mutex_);
  void LeaveCall() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the sessions of the open streams of a map.
  std::set<SessionName> SessionsOf(MapKey map) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends all streams of a map.
  void EndMap(MapKey map, const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Refuses new uploads and drains all streams.
  void Drain() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Waits until all uploads have ended. Returns false at `deadline`.
  bool AwaitEmpty(absl::Time deadline) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Sets a new limit on the number of streams. Open streams continue.
  void SetMaxStreams(std::size_t max_streams) ABSL_LOCKS_EXCLUDED(mutex_);

  std::size_t stream_count() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  using Key = std::pair<MapKey, SensorName>;

  bool IsEmpty() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return streams_.empty() && superseded_ == 0 && calls_ == 0;
  }

  /// An open stream.
  struct Stream {
    SessionName session;
    std::shared_ptr<ActiveUpload> upload;
  };

  mutable absl::Mutex mutex_;
  std::size_t max_streams_ ABSL_GUARDED_BY(mutex_);
  std::map<Key, Stream> streams_ ABSL_GUARDED_BY(mutex_);
  std::size_t superseded_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Replaced, but still open.
  std::size_t calls_ ABSL_GUARDED_BY(mutex_) = 0;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
};

/// Returns the maximum number of simultaneous streams under `limits`.
std::size_t MaxUploadStreams(const LimitOptions& limits);

/// Returns the error for uploads to a draining server.
absl::Status DrainingError();

}  // namespace steadymap

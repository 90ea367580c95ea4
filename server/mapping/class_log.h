#pragma once

#include <functional>
#include <memory>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include "core/frame/frame.h"
#include "core/types/map_config.h"

namespace steadymap {

/// Classes that wait for the log.
struct PendingClasses {
  std::vector<SemanticClass> classes;
  std::function<void(absl::Status)> done;  ///< Called once, with the result.
};

/// The class table of a map at the head of its log, and the additions that wait for the log. Images
/// are checked against the former, further additions against both. Thread-safe.
class ClassLog {
 public:
  /// `config` is the configuration that the map was created with.
  explicit ClassLog(const MapConfig& config);

  /// Replaces the table by the one read from the store.
  void Reset(std::vector<SemanticClass> durable) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Adds classes whose log entry is durable.
  void Append(const std::vector<SemanticClass>& added) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the table at the head of the log.
  std::vector<SemanticClass> classes() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the values that are valid in label images.
  std::shared_ptr<const KnownLabels> labels() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Queues classes for the log. Errors, for which `done` is not called: `InvalidArgument` for
  /// classes that conflict with the table or with queued ones; the status of `Close`.
  absl::Status Queue(PendingClasses pending) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Takes all queued additions.
  std::vector<PendingClasses> TakeQueued() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Refuses all further additions with `status`, and takes the queued ones.
  std::vector<PendingClasses> Close(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  const MapConfig config_;

  mutable absl::Mutex mutex_;
  std::vector<SemanticClass> durable_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<const KnownLabels> labels_ ABSL_GUARDED_BY(mutex_);
  std::vector<PendingClasses> queued_ ABSL_GUARDED_BY(mutex_);
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);  ///< OK until `Close`.
};

}  // namespace steadymap

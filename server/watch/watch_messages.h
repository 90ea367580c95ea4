#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/support/byte_buffer.h>

#include "core/types/cancellation.h"
#include "server/store/model/store.h"
#include "server/watch/resume_token.h"
#include "server/watch/watch_step.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// The messages of one step, each made at the first request. All watchers with the same filter and
/// step share them. The messages of a small step are kept, so each is made once. Those of a large
/// step are made for each watcher, so that a stalled watcher uses little memory. Thread-safe.
class WatchMessages {
 public:
  /// Sources of the messages, in addition to the step.
  struct Source {
    Store* store = nullptr;  ///< Must outlive the messages; null for a step without events.
    MapFilter filter;
    StepKey key;          ///< Key of the step.
    WatchPosition after;  ///< Position after the step.
  };

  /// Plans the messages of `step`. Cost: a pass over its objects and leaves, which stops early on
  /// cancellation; the messages must not be used then.
  WatchMessages(Source source, StepPlan step, const Cancellation& cancellation = {});

  /// Returns the number of messages, including empty ones, which are not sent.
  std::size_t count() const { return fragments_.size() + event_pages_ + 1; }

  /// Returns the message at index `place`, below `count()`; none if it would be empty. Errors:
  /// `Aborted` with reason `SLOW_CONSUMER` if the events are no longer stored; those of the store.
  absl::StatusOr<std::optional<grpc::ByteBuffer>> At(std::size_t place) ABSL_LOCKS_EXCLUDED(mutex_);

  const StepKey& key() const { return source_.key; }

  /// True if each message except the last contains a token to resume after it. Messages of small
  /// steps have no tokens, because a token would be a large part of their size.
  bool is_resumable() const { return is_resumable_; }

  const WatchPosition& after() const { return source_.after; }

  const std::shared_ptr<const ShownObjects>& shown() const { return step_.shown; }

 private:
  /// Half-open ranges [first, last) of the lists of the step.
  struct Fragment {
    std::size_t first_removed = 0;
    std::size_t last_removed = 0;
    std::size_t first_object = 0;
    std::size_t last_object = 0;
    std::size_t first_leaf = 0;
    std::size_t last_leaf = 0;
  };

  std::size_t PlanFragments(const Cancellation& cancellation);
  absl::StatusOr<std::optional<grpc::ByteBuffer>> Make(std::size_t place) const;
  v1::WatchMapResponse MakeFragment(std::size_t place) const;
  absl::StatusOr<v1::WatchMapResponse> MakeEvents(std::size_t page) const;
  std::string TokenBehind(std::size_t place) const;
  v1::WatchMapResponse MakeProgress() const;
  void AddLeaf(const LeafKey& key,
               google::protobuf::RepeatedPtrField<v1::PackedLeaf>* leaves) const;

  const Source source_;
  const StepPlan step_;
  std::vector<Fragment> fragments_;
  std::size_t event_pages_ = 0;
  bool keeps_ = false;  ///< Messages are kept in memory.
  bool is_resumable_ = false;

  absl::Mutex mutex_;
  std::vector<std::optional<std::optional<grpc::ByteBuffer>>> kept_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap

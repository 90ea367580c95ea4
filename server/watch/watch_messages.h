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

/// The messages of one step, made when they are first asked for. All watchers with the same filter
/// who take the same step share them: a small step's messages are kept, so that each is made once;
/// those of a large one are made for each watcher, so that one who stalls holds little.
/// Thread-safe.
class WatchMessages {
 public:
  /// What a step's messages are made of besides the step.
  struct Source {
    Store* store = nullptr;  ///< Outlives the messages; null for a step without events.
    MapFilter filter;
    StepKey key;          ///< Of the step.
    WatchPosition after;  ///< What the watcher then has.
  };

  /// The messages of `step`. Cost: a pass over its objects and leaves, which ends early once
  /// `cancellation` says so; the messages are then of no use.
  WatchMessages(Source source, StepPlan step, const Cancellation& cancellation = {});

  /// Number of messages, those included that turn out to say nothing.
  std::size_t count() const { return fragments_.size() + event_pages_ + 1; }

  /// The message at `place`, below `count()`; none if it would say nothing.
  /// Errors: `Aborted` with reason `SLOW_CONSUMER` for events that are no longer kept; what the
  /// store answers.
  absl::StatusOr<std::optional<grpc::ByteBuffer>> At(std::size_t place) ABSL_LOCKS_EXCLUDED(mutex_);

  const StepKey& key() const { return source_.key; }

  /// Whether each message but the last brings a token for going on behind it. Those of small steps
  /// do not: the token would be a good part of all that is sent.
  bool is_resumable() const { return is_resumable_; }

  const WatchPosition& after() const { return source_.after; }

  const std::shared_ptr<const ShownObjects>& shown() const { return step_.shown; }

 private:
  /// The first and the last but one of each list that a fragment holds.
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
  bool keeps_ = false;  ///< Whether messages are kept.
  bool is_resumable_ = false;

  absl::Mutex mutex_;
  std::vector<std::optional<std::optional<grpc::ByteBuffer>>> kept_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap

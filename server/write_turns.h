#pragma once

#include <set>
#include <utility>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "core/identifiers.h"

namespace steadymap {

/// Lets the writes of one map happen one after another, and those of different maps at once. A turn
/// is not a lock: nothing but other writers of the map waits for it, so it may be held while the
/// disk syncs.
class WriteTurns {
 public:
  /// A turn for some maps, held from construction to destruction.
  class Turn {
   public:
    /// Waits until nobody has a turn for any of `maps`. A thread holds one turn of a `WriteTurns`
    /// at a time.
    Turn(WriteTurns* turns, std::vector<MapKey> maps) : turns_(turns), maps_(std::move(maps)) {
      const auto all_free = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(turns_->mutex_) {
        for (const MapKey map : maps_) {
          if (turns_->taken_.contains(map)) return false;
        }
        return true;
      };
      const absl::MutexLock lock(&turns_->mutex_, absl::Condition(&all_free));
      turns_->taken_.insert(maps_.begin(), maps_.end());
    }

    ~Turn() {
      const absl::MutexLock lock(&turns_->mutex_);
      for (const MapKey map : maps_) turns_->taken_.erase(map);
    }

    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    WriteTurns* turns_;
    std::vector<MapKey> maps_;
  };

 private:
  absl::Mutex mutex_;
  std::set<MapKey> taken_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap

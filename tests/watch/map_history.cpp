#include "tests/watch/map_history.h"

#include <utility>

#include "proto/convert_object.h"

namespace steadymap {

void MapHistory::Add(const MapDelta& delta) {
  const absl::MutexLock lock(&mutex_);
  if (delta.from != head_) ++gaps_;
  commits_[delta.from] = std::make_shared<const MapDelta>(delta);
  head_ = delta.to;
}

std::shared_ptr<const MapDelta> MapHistory::After(Revision from) const {
  const absl::MutexLock lock(&mutex_);
  const auto commit = commits_.find(from);
  return commit == commits_.end() ? nullptr : commit->second;
}

Revision MapHistory::head() const {
  const absl::MutexLock lock(&mutex_);
  return head_;
}

std::size_t MapHistory::gaps() const {
  const absl::MutexLock lock(&mutex_);
  return gaps_;
}

bool MapReplay::GoTo(Revision revision) {
  while (revision_ < revision) {
    const std::shared_ptr<const MapDelta> commit = history_->After(revision_);
    if (commit == nullptr || commit->to > revision) return false;
    for (const ObjectChange& change : commit->objects) {
      if (change.state) {
        objects_[change.id] = *change.state;
      } else {
        objects_.erase(change.id);
      }
    }
    for (const LeafChange& change : commit->leaves) {
      if (change.packed.empty()) {
        leaves_.erase(change.key);
      } else {
        leaves_[change.key] = change.packed;
      }
    }
    for (const ObjectEvent& event : commit->events) {
      last_event_ = last_event_.Next();
      events_.push_back({last_event_, event});
    }
    revision_ = commit->to;
    last_capture_time_ = commit->last_capture_time;
  }
  return revision_ == revision;
}

WatchedContent MapReplay::Shown(const MapFilter& filter) const {
  WatchedContent shown;
  std::map<ObjectId, std::uint64_t> leaf_counts;
  for (const auto& [key, packed] : leaves_) {
    ++leaf_counts[key.object];
    if (!filter.volumes) continue;
    const auto owner = objects_.find(key.object);
    const bool passes = key.object == kBackgroundId
                            ? filter.ShowsBackgroundLeaf(key.origin, scale_)
                            : owner != objects_.end() && filter.Shows(owner->second);
    if (passes) shown.leaves[key] = packed;
  }
  if (!filter.WantsObjects()) return shown;
  for (const auto& [id, state] : objects_) {
    if (!filter.Shows(state)) continue;
    v1::Object message = ToProto(MapObject{state, nullptr});
    message.set_leaves(leaf_counts[id]);
    shown.objects[id] = message.SerializeAsString();
  }
  return shown;
}

const ObjectState* MapReplay::Find(ObjectId id) const {
  const auto object = objects_.find(id);
  return object == objects_.end() ? nullptr : &object->second;
}

std::vector<MapReplay::NumberedEvent> MapReplay::TakeEvents() { return std::exchange(events_, {}); }

}  // namespace steadymap

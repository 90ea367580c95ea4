#include "core/mapper.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "core/tsdf_codec.h"

namespace steadymap {

absl::StatusOr<std::unique_ptr<Mapper>> Mapper::Create(const MapConfig& config) {
  if (absl::Status status = ValidateMapConfig(config); !status.ok()) return status;
  return std::unique_ptr<Mapper>(new Mapper(config));
}

Mapper::Mapper(const MapConfig& config) : config_(config), cloud_(config), integrator_(config) {
  map_.scale = {config.voxel_size_m, config.truncation_m};
  if (config.policy == UpdatePolicy::kPocd) {
    object_mapper_ = std::make_unique<ObjectMapper>(config, ObjectMapperParameters{});
  }
}

void Mapper::Restore(const MapSnapshot& snapshot) {
  assert(snapshot.scale == map_.scale && uncommitted_frames_ == 0);
  map_ = snapshot;
  head_ = MapSequence(snapshot.revision.value());
  committed_ = snapshot.revision;
}

void Mapper::Integrate(MapSequence sequence, const Frame& frame) {
  assert(sequence == head_.Next());
  assert(ValidateFrame(frame, config_.label_limit()).ok());
  cloud_.Compute(frame);
  if (object_mapper_ != nullptr) {
    object_mapper_->Process(
        Revision(sequence.value()), frame, &cloud_, &integrator_, &map_.background);
  } else {
    std::vector<LeafOrigin> origins;
    integrator_.Integrate(cloud_, &map_.background, &origins);
    for (const LeafOrigin& origin : origins) changed_leaves_.push_back({kBackgroundId, origin});
  }
  head_ = sequence;
  map_.last_capture_time = frame.capture_time;
  ++uncommitted_frames_;
}

/// Publishes the objects that changed, and hands over what else did.
void Mapper::TakeObjectChanges(MapDelta* delta) {
  ObjectChanges changes = object_mapper_->TakeChanges();
  changed_leaves_ = std::move(changes.leaves);
  delta->events = std::move(changes.events);
  for (const ObjectId id : changes.objects) {
    map_.objects[id] = object_mapper_->objects().at(id).Publish();
  }
}

MapCommit Mapper::Commit() {
  MapCommit commit;
  commit.delta.from = committed_;
  commit.delta.to = Revision(head_.value());
  commit.delta.last_capture_time = map_.last_capture_time;

  if (object_mapper_ != nullptr) TakeObjectChanges(&commit.delta);
  std::sort(changed_leaves_.begin(), changed_leaves_.end());
  changed_leaves_.erase(std::unique(changed_leaves_.begin(), changed_leaves_.end()),
                        changed_leaves_.end());
  commit.delta.leaves.reserve(changed_leaves_.size());
  for (const LeafKey& key : changed_leaves_) {
    const LeafView leaf = key.object == kBackgroundId
                              ? map_.background.FindLeaf(key.origin)
                              : map_.objects.at(key.object)->volume->FindLeaf(key.origin);
    commit.delta.leaves.push_back({key, leaf ? PackLeaf(leaf, map_.scale) : std::string()});
  }
  changed_leaves_.clear();
  uncommitted_frames_ = 0;

  map_.revision = commit.delta.to;
  committed_ = map_.revision;
  commit.snapshot = std::make_shared<const MapSnapshot>(map_);
  return commit;
}

}  // namespace steadymap

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
  integrator_.Integrate(cloud_, &map_.background, &changed_leaves_);
  head_ = sequence;
  map_.last_capture_time = frame.capture_time;
  ++uncommitted_frames_;
}

MapCommit Mapper::Commit() {
  MapCommit commit;
  commit.delta.from = committed_;
  commit.delta.to = Revision(head_.value());
  commit.delta.last_capture_time = map_.last_capture_time;

  std::sort(changed_leaves_.begin(), changed_leaves_.end());
  changed_leaves_.erase(std::unique(changed_leaves_.begin(), changed_leaves_.end()),
                        changed_leaves_.end());
  commit.delta.leaves.reserve(changed_leaves_.size());
  for (const LeafOrigin& origin : changed_leaves_) {
    commit.delta.leaves.push_back(
        {{kBackgroundId, origin}, PackLeaf(map_.background.FindLeaf(origin), map_.scale)});
  }
  changed_leaves_.clear();
  uncommitted_frames_ = 0;

  map_.revision = commit.delta.to;
  committed_ = map_.revision;
  commit.snapshot = std::make_shared<const MapSnapshot>(map_);
  return commit;
}

}  // namespace steadymap

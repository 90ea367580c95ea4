#include "core/mapper.h"

#include <cassert>

namespace steadymap {

absl::StatusOr<std::unique_ptr<Mapper>> Mapper::Create(const MapConfig& config) {
  if (absl::Status status = ValidateMapConfig(config); !status.ok()) return status;
  return std::unique_ptr<Mapper>(new Mapper(config));
}

Mapper::Mapper(const MapConfig& config)
    : config_(config), cloud_(config), updater_(MakeMapUpdater(config)), map_(config) {}

void Mapper::Restore(const MapSnapshot& snapshot) {
  assert(uncommitted_frames_ == 0);
  map_.Restore(snapshot);
}

void Mapper::Integrate(MapSequence sequence, const Frame& frame) {
  assert(sequence == head().Next());
  assert(ValidateFrame(frame, config_.label_limit()).ok());
  cloud_.Compute(frame);
  map_.BeginFrame(Revision(sequence.value()), frame.capture_time);
  updater_->Process(frame, &cloud_, &map_);
  map_.EndFrame();
  ++uncommitted_frames_;
}

MapCommit Mapper::Commit() {
  uncommitted_frames_ = 0;
  return map_.Commit();
}

}  // namespace steadymap

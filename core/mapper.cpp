#include "core/mapper.h"

#include <cassert>

namespace steadymap {
namespace {

/// The other policies have no switches.
bool DropsDynamicClasses(const MapConfig& config, const EngineSwitches& switches) {
  return config.policy != UpdatePolicy::kPocd || switches.dynamic_mask;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Mapper>> Mapper::Create(const MapConfig& config,
                                                       const MapperOptions& options) {
  if (absl::Status status = ValidateMapConfig(config); !status.ok()) return status;
  return std::unique_ptr<Mapper>(new Mapper(config, options));
}

Mapper::Mapper(const MapConfig& config, const MapperOptions& options)
    : config_(config),
      stages_(options.stages),
      cloud_(config, DropsDynamicClasses(config, options.switches)),
      updater_(MakeMapUpdater(config, options)),
      map_(config) {}

void Mapper::Restore(const MapSnapshot& snapshot) {
  assert(uncommitted_frames_ == 0);
  map_.Restore(snapshot);
}

void Mapper::Integrate(MapSequence sequence, const Frame& frame) {
  assert(sequence == head().Next());
  assert(ValidateFrame(frame, config_.label_limit()).ok());
  stages_.Enter(MapperStage::kCloud);
  cloud_.Compute(frame);
  map_.BeginFrame(Revision(sequence.value()), frame.capture_time);
  stages_.Enter(MapperStage::kPolicy);
  updater_->Process(frame, &cloud_, &map_);
  stages_.Enter(MapperStage::kFrameEnd);
  map_.EndFrame();
  stages_.Leave();
  ++uncommitted_frames_;
}

MapCommit Mapper::Commit() {
  uncommitted_frames_ = 0;
  stages_.Enter(MapperStage::kCommit);
  MapCommit commit = map_.Commit();
  stages_.Leave();
  return commit;
}

}  // namespace steadymap

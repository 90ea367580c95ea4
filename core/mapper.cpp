#include "core/mapper.h"

#include <cassert>

namespace steadymap {
namespace {

/// Only the policy `pocd` has switches.
bool DropsDynamicClasses(const MapConfig& config, const Ablation& switches) {
  return config.policy != UpdatePolicy::kPocd || switches.dynamic_mask;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Mapper>> Mapper::Create(const MapConfig& config,
                                                       const MapperOptions& options) {
  if (absl::Status status = ValidateMapConfig(config); !status.ok()) return status;
  return std::unique_ptr<Mapper>(new Mapper(config, options));
}

Mapper::Mapper(const MapConfig& config, const MapperOptions& options)
    : created_classes_(config.classes),
      config_(config),
      options_(options),
      stages_(options.stages),
      map_(config) {
  UseClasses();
}

void Mapper::UseClasses() {
  config_.classes = created_classes_;
  const std::vector<SemanticClass>& added = map_.added_classes();
  config_.classes.insert(config_.classes.end(), added.begin(), added.end());
  ReleaseFrameMemory();
}

/// All state that outlives a frame is in the map, so the other objects can be created again.
void Mapper::ReleaseFrameMemory() {
  cloud_.reset();
  updater_.reset();
}

void Mapper::PrepareForFrames() {
  if (updater_ != nullptr) return;
  cloud_ =
      std::make_unique<SemanticCloud>(config_, DropsDynamicClasses(config_, options_.switches));
  updater_ = MakeMapUpdater(config_, options_);
}

void Mapper::Restore(const MapSnapshot& snapshot) {
  assert(uncommitted_entries_ == 0);
  map_.Restore(snapshot);
  if (!snapshot.added_classes.empty()) UseClasses();
}

void Mapper::AddClasses(MapSequence sequence, const std::vector<SemanticClass>& classes) {
  assert(sequence == head().Next());
  map_.AddClasses(Revision(sequence.value()), classes);
  UseClasses();
  assert(ValidateMapConfig(config_).ok());
  ++uncommitted_entries_;
}

void Mapper::Skip(MapSequence sequence) {
  assert(sequence == head().Next());
  map_.Advance(Revision(sequence.value()));
  ++uncommitted_entries_;
}

void Mapper::Integrate(MapSequence sequence, const Frame& frame) {
  assert(sequence == head().Next());
  assert(ValidateFrame(frame, KnownLabels(config_.classes)).ok());
  PrepareForFrames();
  stages_.Enter(MapperStage::kCloud);
  cloud_->Compute(frame);
  map_.BeginFrame(Revision(sequence.value()), frame.capture_time);
  stages_.Enter(MapperStage::kPolicy);
  updater_->Process(frame, cloud_.get(), &map_);
  stages_.Enter(MapperStage::kFrameEnd);
  map_.EndFrame();
  stages_.Leave();
  ++uncommitted_entries_;
}

void Mapper::EndSession(MapSequence sequence) {
  assert(sequence == head().Next());
  PrepareForFrames();
  map_.BeginFrame(Revision(sequence.value()), map_.now());
  updater_->EndSession(&map_);
  map_.EndFrame();
  ++uncommitted_entries_;
}

MapCommit Mapper::Commit() {
  uncommitted_entries_ = 0;
  stages_.Enter(MapperStage::kCommit);
  MapCommit commit = map_.Commit();
  stages_.Leave();
  return commit;
}

}  // namespace steadymap

#include "core/mapper.h"

#include <cassert>

namespace steadymap {

absl::StatusOr<std::unique_ptr<Mapper>> Mapper::Create(const MapConfig& config,
                                                       StageObserver* stages) {
  if (absl::Status status = ValidateMapConfig(config); !status.ok()) return status;
  return std::unique_ptr<Mapper>(new Mapper(config, stages));
}

Mapper::Mapper(const MapConfig& config, StageObserver* stages)
    : created_classes_(config.classes),
      config_(config),
      observer_(stages),
      stages_(stages),
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
  cloud_ = std::make_unique<SemanticCloud>(config_);
  updater_ = MakeMapUpdater(config_, observer_);
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
  const Revision revision(sequence.value());
  if (updater_->IsSessionOver(frame, map_)) DecideSession(revision, frame.source);
  stages_.Enter(MapperStage::kCloud);
  cloud_->Compute(frame);
  map_.BeginFrame(revision, frame.capture_time);
  stages_.Enter(MapperStage::kPolicy);
  updater_->Process(frame, cloud_.get(), &map_);
  stages_.Enter(MapperStage::kFrameEnd);
  map_.EndFrame();
  stages_.Leave();
  ++uncommitted_entries_;
}

void Mapper::EndSession(MapSequence sequence, const SensorName& sensor) {
  assert(sequence == head().Next());
  PrepareForFrames();
  DecideSession(Revision(sequence.value()), sensor);
  ++uncommitted_entries_;
}

/// Ends the session of a robot, at the time of its last frame.
void Mapper::DecideSession(Revision revision, const SensorName& sensor) {
  stages_.Enter(MapperStage::kSessionEnd);
  map_.BeginSessionEnd(revision, sensor);
  updater_->EndSession(sensor, &map_);
  map_.EndFrame();
  stages_.Leave();
}

MapCommit Mapper::Commit() {
  uncommitted_entries_ = 0;
  stages_.Enter(MapperStage::kCommit);
  MapCommit commit = map_.Commit();
  stages_.Leave();
  return commit;
}

}  // namespace steadymap

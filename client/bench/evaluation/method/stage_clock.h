#pragma once

#include <array>
#include <chrono>

#include "core/policy/stage_observer.h"

namespace steadymap {

/// Milliseconds per stage, indexed by `MapperStage`.
using StageTimes = std::array<double, kMapperStageCount>;

/// Sums the wall time that a mapper spends in each stage. Not thread-safe.
class StageClock final : public StageObserver {
 public:
  void Enter(MapperStage stage) override;
  void Leave() override;

  /// Time spent so far.
  const StageTimes& total_ms() const { return total_ms_; }

 private:
  void Stop(std::chrono::steady_clock::time_point now);

  StageTimes total_ms_{};
  bool is_running_ = false;
  MapperStage stage_ = MapperStage::kCloud;        ///< Current stage, if running.
  std::chrono::steady_clock::time_point start_{};  ///< Start of the current stage.
};

}  // namespace steadymap

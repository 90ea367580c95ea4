#pragma once

#include <array>
#include <chrono>

#include "core/policy/stage_observer.h"

namespace steadymap {

/// Milliseconds by stage, as in `MapperStage`.
using StageTimes = std::array<double, kMapperStageCount>;

/// Sums up the wall time that a mapper spends in each stage. One thread at a time.
class StageClock final : public StageObserver {
 public:
  void Enter(MapperStage stage) override;
  void Leave() override;

  /// What was spent so far.
  const StageTimes& total_ms() const { return total_ms_; }

 private:
  void Stop(std::chrono::steady_clock::time_point now);

  StageTimes total_ms_{};
  bool is_running_ = false;
  MapperStage stage_ = MapperStage::kCloud;        ///< While it runs: the one at hand,
  std::chrono::steady_clock::time_point start_{};  ///< and since when.
};

}  // namespace steadymap

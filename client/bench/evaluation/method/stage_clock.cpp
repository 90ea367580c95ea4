#include "client/bench/evaluation/method/stage_clock.h"

namespace steadymap {

void StageClock::Enter(MapperStage stage) {
  const auto now = std::chrono::steady_clock::now();
  Stop(now);
  is_running_ = true;
  stage_ = stage;
  start_ = now;
}

void StageClock::Leave() { Stop(std::chrono::steady_clock::now()); }

void StageClock::Stop(std::chrono::steady_clock::time_point now) {
  if (!is_running_) return;
  const std::chrono::duration<double, std::milli> elapsed = now - start_;
  total_ms_[static_cast<std::size_t>(stage_)] += elapsed.count();
  is_running_ = false;
}

}  // namespace steadymap

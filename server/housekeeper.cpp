#include "server/housekeeper.h"

#include <algorithm>
#include <chrono>

#include <absl/time/time.h>
#include <spdlog/spdlog.h>

#include "server/system_clock.h"

namespace steadymap {

Housekeeper::Housekeeper(const MapDirectory* maps,
                         WatchHub* watches,
                         StreamGate* streams,
                         Store* store,
                         const RetentionOptions& options)
    : maps_(maps),
      watches_(watches),
      streams_(streams),
      store_(store),
      options_(options),
      thread_([this] { Run(); }) {}

Housekeeper::~Housekeeper() {
  {
    const absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.join();
}

void Housekeeper::Run() {
  Heartbeat::Clock::time_point due = Heartbeat::Clock::now() + options_.trim_interval;
  while (!AwaitStop()) {
    heartbeat_.Beat();
    watches_->CancelStalled();
    streams_->EndStalled(GatedStream::Clock::now());
    if (Heartbeat::Clock::now() < due) continue;
    TrimAll();
    due = Heartbeat::Clock::now() + options_.trim_interval;
  }
}

void Housekeeper::TrimAll() {
  const Timestamp now = Now();
  const auto idle = std::chrono::duration_cast<std::chrono::nanoseconds>(options_.session_idle);
  const Timestamp forget_before = Timestamp::FromNanoseconds(now.nanoseconds() - idle.count());
  for (const std::shared_ptr<MapRuntime>& map : maps_->All()) {
    heartbeat_.Beat();
    if (!map->condition().ok()) continue;
    map->sessions().ForgetIdle(forget_before);
    const MapSequence integrated(map->snapshot()->revision.value());
    const absl::Status status = store_->Trim(
        map->record(), {integrated, now, forget_before, watches_->OldestWatched(map->key())});
    // A map that was deleted meanwhile is nothing to worry about.
    if (!status.ok() && !absl::IsNotFound(status)) {
      spdlog::warn("map {}: its log could not be trimmed: {}",
                   map->name().ToString(),
                   std::string(status.message()));
    }
  }
}

bool Housekeeper::AwaitStop() {
  const absl::MutexLock lock(&mutex_);
  return mutex_.AwaitWithTimeout(absl::Condition(&stopping_),
                                 absl::FromChrono(Heartbeat::kMaxInterval));
}

}  // namespace steadymap

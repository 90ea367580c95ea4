#include "server/maintenance.h"

#include <chrono>

#include <absl/time/clock.h>
#include <absl/time/time.h>
#include <spdlog/spdlog.h>

#include "server/process/worker_pool.h"

namespace steadymap {
namespace {

// Interval of trims while the disk is low.
constexpr std::chrono::seconds kLowDiskInterval{5};

}  // namespace

Maintenance::Maintenance(const Dependencies& dependencies,
                         const RetentionOptions& options,
                         const SessionOptions& sessions)
    : dependencies_(dependencies),
      options_(options),
      sessions_(sessions),
      thread_([this] { Run(); }) {}

Maintenance::~Maintenance() {
  {
    const absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.join();
}

void Maintenance::Run() {
  NameThread("maintenance");
  Heartbeat::Clock::time_point due = Heartbeat::Clock::now() + options_.trim_interval;
  Heartbeat::Clock::time_point low_disk_due = Heartbeat::Clock::now();
  while (!AwaitStop()) {
    heartbeat_.Beat();
    dependencies_.watches->EndStalled();
    dependencies_.watches->DropHeld(absl::Now());
    dependencies_.streams->EndStalled(LimitedStream::Clock::now());
    EndSilentSessions();
    const Heartbeat::Clock::time_point now = Heartbeat::Clock::now();
    const bool disk_is_low = now >= low_disk_due && !dependencies_.store->CheckDisk().ok();
    if (now < due && !disk_is_low) continue;
    if (disk_is_low) low_disk_due = now + kLowDiskInterval;
    TrimAll(disk_is_low);
    if (now >= due) due = Heartbeat::Clock::now() + options_.trim_interval;
  }
}

void Maintenance::EndSilentSessions() {
  for (const std::shared_ptr<MapRuntime>& map : dependencies_.maps->All()) {
    map->EndSilentSessions(sessions_.max_silence);
  }
}

void Maintenance::TrimAll(bool disk_is_low) {
  for (const std::shared_ptr<MapRuntime>& map : dependencies_.maps->All()) {
    heartbeat_.Beat();
    if (!map->CheckReads().ok()) continue;
    TrimBounds bounds;
    bounds.uptime = map->clock().Now();
    bounds.forget_sessions_before = bounds.uptime - options_.session_idle;
    bounds.sessions_in_use = dependencies_.uploads->SessionsOf(map->key());
    bounds.oldest_watched = dependencies_.watches->OldestWatched(map->key());
    bounds.disk_is_low = disk_is_low;
    map->sessions().ForgetIdle(bounds.forget_sessions_before, bounds.sessions_in_use);
    const absl::Status status = dependencies_.store->Trim(map->record(), bounds);
    // NotFound: the map was deleted meanwhile. A low disk is logged elsewhere.
    if (!status.ok() && !absl::IsNotFound(status) && !disk_is_low) {
      spdlog::warn("map {}: its log could not be trimmed: {}",
                   map->name().ToString(),
                   std::string(status.message()));
    }
  }
}

bool Maintenance::AwaitStop() {
  const absl::MutexLock lock(&mutex_);
  return mutex_.AwaitWithTimeout(absl::Condition(&stopping_),
                                 absl::FromChrono(Heartbeat::kMaxInterval));
}

}  // namespace steadymap

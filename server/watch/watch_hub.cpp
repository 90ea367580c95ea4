#include "server/watch/watch_hub.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>

#include "core/types/error.h"
#include "server/upload/upload_registry.h"

namespace steadymap {
namespace {

// Watchers of one map that are up to date share one step per filter. A step contains its messages
// and a snapshot; the snapshot is cheap while the map has changed little since.
constexpr std::size_t kMaxSharedSteps = 16;

// A disconnected watcher returns within seconds, or is so far behind that it cannot use the step.
// Until then a step keeps old data of the map in memory.
constexpr std::size_t kMaxHeldSteps = 32;
constexpr absl::Duration kHoldTime = absl::Minutes(1);

// A watcher further behind receives whole leaves. At the usual commit rate 4 snapshots cover most
// of a second.
constexpr std::size_t kRecentSnapshots = 4;

absl::Status StalledError(absl::Duration timeout) {
  return MakeError(
      absl::StatusCode::kAborted,
      reason::kSlowConsumer,
      absl::StrCat("the watcher has read nothing for ", absl::ToInt64Seconds(timeout), " s"));
}

}  // namespace

absl::Status WatchHub::Enter(MapKey map, std::shared_ptr<ActiveWatch> watch) {
  const absl::MutexLock lock(&mutex_);
  if (draining_) return DrainingError();
  if (count_ >= dependencies_.max_watches) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     reason::kQueueFull,
                     absl::StrCat("the server has ", count_, " watches, which is the maximum"));
  }
  if (maps_[map].watches.insert(std::move(watch)).second) ++count_;
  return absl::OkStatus();
}

void WatchHub::Leave(MapKey map, const std::shared_ptr<ActiveWatch>& watch) {
  const absl::MutexLock lock(&mutex_);
  const auto watched = maps_.find(map);
  if (watched == maps_.end()) return;
  count_ -= watched->second.watches.erase(watch);
  if (!watched->second.watches.empty()) return;
  maps_.erase(watched);
  std::erase_if(steps_, [map](const auto& step) { return step->key.scope.map == map; });
}

void WatchHub::OnCommit(MapKey map) {
  for (const std::shared_ptr<ActiveWatch>& watch : WatchesOf(map)) watch->Wake();
}

void WatchHub::EndStalled() {
  const absl::Time stalled = absl::Now() - dependencies_.stall_timeout;
  const absl::Time given_up = stalled - dependencies_.stall_grace;
  for (const std::shared_ptr<ActiveWatch>& watch : All()) {
    const absl::Time since = watch->sending_since();
    if (since < given_up) {
      watch->Cancel();
    } else if (since < stalled) {
      watch->End(StalledError(dependencies_.stall_timeout));
    }
  }
}

std::optional<Revision> WatchHub::OldestWatched(MapKey map) const {
  std::optional<Revision> oldest;
  for (const std::shared_ptr<ActiveWatch>& watch : WatchesOf(map)) {
    oldest = std::min(oldest.value_or(watch->revision()), watch->revision());
  }
  return oldest;
}

void WatchHub::EndMap(MapKey map, const absl::Status& status) {
  {
    const absl::MutexLock lock(&mutex_);
    std::erase_if(held_,
                  [map](const HeldStep& held) { return held.messages->key().scope.map == map; });
  }
  for (const std::shared_ptr<ActiveWatch>& watch : WatchesOf(map)) watch->End(status);
}

void WatchHub::Drain() {
  {
    const absl::MutexLock lock(&mutex_);
    draining_ = true;
  }
  for (const std::shared_ptr<ActiveWatch>& watch : All()) watch->Drain();
}

bool WatchHub::AwaitEmpty(absl::Time deadline) {
  const absl::MutexLock lock(&mutex_);
  return mutex_.AwaitWithDeadline(absl::Condition(this, &WatchHub::IsEmpty), deadline);
}

void WatchHub::CancelAll() {
  for (const std::shared_ptr<ActiveWatch>& watch : All()) watch->Cancel();
}

std::size_t WatchHub::watch_count() const {
  const absl::MutexLock lock(&mutex_);
  return count_;
}

absl::StatusOr<std::shared_ptr<WatchMessages>> WatchHub::FindStep(const StepRequest& request) {
  const std::shared_ptr<SharedStep> step = ShareStep(KeyOf(request));
  // A second watcher waits here until the first has made the step.
  const absl::MutexLock lock(&step->mutex);
  if (step->messages == nullptr) {
    absl::StatusOr<std::shared_ptr<WatchMessages>> messages = MakeStep(request);
    if (!messages.ok()) return messages.status();
    step->messages = *std::move(messages);
  }
  return step->messages;
}

void WatchHub::Hold(std::shared_ptr<WatchMessages> step) {
  const absl::Time until = absl::Now() + kHoldTime;
  const absl::MutexLock lock(&mutex_);
  std::erase_if(held_,
                [&step](const HeldStep& held) { return held.messages->key() == step->key(); });
  held_.push_front({std::move(step), until});
  if (held_.size() > kMaxHeldSteps) held_.pop_back();
}

std::shared_ptr<WatchMessages> WatchHub::FindHeld(const StepKey& key) const {
  for (const std::shared_ptr<ActiveWatch>& watch : WatchesOf(key.scope.map)) {
    std::shared_ptr<WatchMessages> step = watch->step();
    if (step != nullptr && step->key() == key) return step;
  }
  std::shared_ptr<SharedStep> sent;
  {
    const absl::MutexLock lock(&mutex_);
    for (const HeldStep& held : held_) {
      if (held.messages->key() == key) return held.messages;
    }
    const auto shared = std::find_if(
        steps_.begin(), steps_.end(), [&key](const auto& step) { return step->key == key; });
    if (shared == steps_.end()) return nullptr;
    sent = *shared;
  }
  const absl::MutexLock lock(&sent->mutex);
  return sent->messages;
}

void WatchHub::DropHeld(absl::Time now) {
  const absl::MutexLock lock(&mutex_);
  std::erase_if(held_, [now](const HeldStep& held) { return held.until < now; });
}

StepKey WatchHub::KeyOf(const StepRequest& request) {
  return {request.scope,
          request.before,
          request.to.commit,
          request.max_message_bytes,
          request.takes_patches,
          request.as_snapshot,
          request.shown != nullptr};
}

absl::StatusOr<std::shared_ptr<WatchMessages>> WatchHub::MakeStep(const StepRequest& request) {
  Store* const store = dependencies_.store;
  const MapKey map = request.scope.map;
  const std::shared_ptr<const MapSnapshot>& snapshot = request.to.snapshot;
  const bool compares = request.filter.volumes && request.takes_patches;
  if (compares) KeepRecent(map, snapshot);
  WatchMessages::Source source{store,
                               request.filter,
                               KeyOf(request),
                               {snapshot->revision,
                                snapshot->last_event,
                                request.to.commit.hash,
                                request.as_snapshot || request.before.has_leaves}};
  if (request.as_snapshot) {
    auto messages = std::make_shared<WatchMessages>(
        std::move(source),
        MakeSnapshotStep(request.filter, snapshot, request.cancellation),
        request.cancellation);
    // Other watchers that wait for this step then make it themselves.
    if (absl::Status status = request.cancellation.Check(); !status.ok()) return status;
    return messages;
  }
  ChangeList changes;
  if (request.filter.WantsObjects()) {
    absl::StatusOr<ChangeList> read =
        store->ReadChanges(map, request.before.commit(), snapshot->revision);
    if (!read.ok()) return read.status();
    changes = *std::move(read);
  }
  StepPlan step =
      MakeDeltaStep(request.filter, changes, request.before.revision, request.shown, snapshot);
  if (compares) step.base = FindRecent(map, request.before.revision);
  return std::make_shared<WatchMessages>(std::move(source), std::move(step));
}

void WatchHub::KeepRecent(MapKey map, const std::shared_ptr<const MapSnapshot>& snapshot) {
  const absl::MutexLock lock(&mutex_);
  const auto watched = maps_.find(map);
  if (watched == maps_.end()) return;
  auto& recent = watched->second.recent;
  const auto older = std::find_if(recent.begin(), recent.end(), [&snapshot](const auto& kept) {
    return kept->revision <= snapshot->revision;
  });
  if (older != recent.end() && (*older)->revision == snapshot->revision) return;
  recent.insert(older, snapshot);
  if (recent.size() > kRecentSnapshots) recent.pop_back();
}

std::shared_ptr<const MapSnapshot> WatchHub::FindRecent(MapKey map, Revision revision) const {
  const absl::MutexLock lock(&mutex_);
  const auto watched = maps_.find(map);
  if (watched == maps_.end()) return nullptr;
  for (const std::shared_ptr<const MapSnapshot>& kept : watched->second.recent) {
    if (kept->revision == revision) return kept;
  }
  return nullptr;
}

std::shared_ptr<WatchHub::SharedStep> WatchHub::ShareStep(const StepKey& key) {
  const absl::MutexLock lock(&mutex_);
  for (const std::shared_ptr<SharedStep>& step : steps_) {
    if (step->key == key) return step;
  }
  auto step = std::make_shared<SharedStep>();
  step->key = key;
  steps_.push_front(step);
  if (steps_.size() > kMaxSharedSteps) steps_.pop_back();
  return step;
}

std::vector<std::shared_ptr<ActiveWatch>> WatchHub::WatchesOf(MapKey map) const {
  const absl::MutexLock lock(&mutex_);
  const auto watched = maps_.find(map);
  if (watched == maps_.end()) return {};
  return {watched->second.watches.begin(), watched->second.watches.end()};
}

std::vector<std::shared_ptr<ActiveWatch>> WatchHub::All() const {
  std::vector<std::shared_ptr<ActiveWatch>> all;
  const absl::MutexLock lock(&mutex_);
  for (const auto& [map, watched] : maps_) {
    all.insert(all.end(), watched.watches.begin(), watched.watches.end());
  }
  return all;
}

}  // namespace steadymap

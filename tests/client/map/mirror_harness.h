#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <absl/synchronization/notification.h>
#include <absl/time/time.h>
#include <gtest/gtest.h>

#include "client/map/map_mirror.h"
#include "core/types/error.h"
#include "proto/grpc_status.h"
#include "tests/client/map/fake_map_server.h"
#include "tests/client/watch/fake_watch_service.h"
#include "tests/client/watch/watch_messages.h"

namespace steadymap {

/// Reached only if a test hangs.
inline constexpr std::chrono::milliseconds kHangTimeout{60'000};

/// Returns the status with which a server's script ends.
inline grpc::Status WatchFailure(absl::StatusCode code, std::string_view reason = {}) {
  return ToGrpcStatus(MakeError(code, reason, "as the script says"));
}

/// A mirror of a scripted server. Never waits between streams, and records the callbacks of the
/// mirror.
class MirrorHarness {
 public:
  MirrorHarness() {
    options.seed = 5;
    options.sleep = [](std::chrono::milliseconds) {};
  }

  ~MirrorHarness() {
    mirror_.reset();
    service.Release();
  }

  MirrorHarness(const MirrorHarness&) = delete;
  MirrorHarness& operator=(const MirrorHarness&) = delete;

  MapMirror& Start(std::vector<FakeWatchService::Script> scripts) {
    service.SetScripts(std::move(scripts));
    MirrorCallbacks callbacks;
    callbacks.on_step = [this](const MirrorStep& step) {
      const std::lock_guard lock(mutex_);
      steps_.push_back(step);
      told_.notify_all();
    };
    callbacks.on_events = [this](std::span<const NumberedEvent> events) {
      const std::lock_guard lock(mutex_);
      for (const NumberedEvent& event : events) event_numbers_.push_back(event.number.value());
      told_.notify_all();
    };
    callbacks.on_state = [this](const WatchStateChange& change) { Note(change); };
    mirror_ = MapMirror::Start(server.channels(), {"default", "kitchen"}, options, callbacks);
    started_.Notify();
    return *mirror_;
  }

  /// Returns the mirror; also callable from scripts and callbacks.
  MapMirror& mirror() {
    started_.WaitForNotification();
    return *mirror_;
  }

  /// Waits for the end of the mirror; returns its final status.
  absl::Status AwaitEnd() {
    EXPECT_TRUE(ended_.WaitForNotificationWithTimeout(absl::FromChrono(kHangTimeout)));
    return mirror_->status();
  }

  /// Waits for a resync.
  void AwaitResync() {
    EXPECT_TRUE(resynced_.WaitForNotificationWithTimeout(absl::FromChrono(kHangTimeout)));
  }

  /// Waits for `count` calls of `on_step`: a step is visible before its callbacks run.
  void AwaitSteps(std::size_t count) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(told_.wait_for(lock, kHangTimeout, [&] { return steps_.size() >= count; }));
  }

  /// Waits for `count` events.
  void AwaitEvents(std::size_t count) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(told_.wait_for(lock, kHangTimeout, [&] { return event_numbers_.size() >= count; }));
  }

  std::vector<MirrorStep> steps() const {
    const std::lock_guard lock(mutex_);
    return steps_;
  }

  std::vector<std::uint64_t> event_numbers() const {
    const std::lock_guard lock(mutex_);
    return event_numbers_;
  }

  /// Returns the changes to this state, in order.
  std::vector<WatchStateChange> Changes(WatchState state) const {
    const std::lock_guard lock(mutex_);
    std::vector<WatchStateChange> found;
    for (const WatchStateChange& change : changes_) {
      if (change.state == state) found.push_back(change);
    }
    return found;
  }

  FakeWatchService service;
  FakeServer server{&service};
  MirrorOptions options;

 private:
  void Note(const WatchStateChange& change) {
    const std::lock_guard lock(mutex_);
    changes_.push_back(change);
    if (change.state == WatchState::kEnded) ended_.Notify();
    if (change.state == WatchState::kResynced && !resynced_.HasBeenNotified()) resynced_.Notify();
  }

  mutable std::mutex mutex_;
  std::condition_variable told_;  ///< Signals a step or events.
  std::vector<MirrorStep> steps_;
  std::vector<std::uint64_t> event_numbers_;
  std::vector<WatchStateChange> changes_;
  absl::Notification started_;
  absl::Notification ended_;
  absl::Notification resynced_;
  std::unique_ptr<MapMirror> mirror_;
};

}  // namespace steadymap

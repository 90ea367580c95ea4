#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/benchmark/frame_feed.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap::benchmarks {

/// What brought a watcher from one revision to the next: everything up to a progress.
struct WatchedStep {
  std::uint64_t revision = 0;  ///< After the step.
  Clock::time_point first;     ///< When its first message came.
  Clock::time_point last;      ///< When the progress came.
  std::uint64_t bytes = 0;     ///< Of all its messages, as serialized.
  std::uint32_t messages = 0;  ///< The progress included.
};

/// How a watcher is to behave.
struct WatcherPlan {
  v1::WatchMapRequest request;
  /// Reads so many messages and then no more, while the call stays open; 0: reads on.
  std::size_t stalls_after = 0;
  bool keeps = false;  ///< Keeps the messages, for `WatcherRecord::messages`.
};

/// What a watcher saw.
struct WatcherRecord {
  std::vector<WatchedStep> steps;
  bool stalled = false;                        ///< As planned: it stopped reading.
  std::vector<v1::WatchMapResponse> messages;  ///< If the plan says so.
  std::string end;                             ///< Why the stream ended before its time; or empty.
};

/// Many watchers over loopback, served by one thread. Messages are counted and dated by their first
/// bytes, not parsed, so that a thousand watchers cost little beside the daemon.
class WatchCrowd {
 public:
  /// Opens `connections` connections (at least 1), deals the watchers out to them and waits until
  /// each has got its first message. Throws `std::runtime_error` if one ends instead.
  WatchCrowd(const std::string& address,
             std::size_t connections,
             const std::vector<WatcherPlan>& plans);
  ~WatchCrowd();

  WatchCrowd(const WatchCrowd&) = delete;
  WatchCrowd& operator=(const WatchCrowd&) = delete;

  /// Waits until every watcher that reads has `revision`; answers whether that came true within
  /// `limit`.
  bool AwaitRevision(std::uint64_t revision, std::chrono::seconds limit);

  /// Ends all watches; the records in the order of the plans.
  std::vector<WatcherRecord> Finish();

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace steadymap::benchmarks

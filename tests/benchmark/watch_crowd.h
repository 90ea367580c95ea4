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

/// A step from one revision to the next: all messages up to a progress.
struct WatchedStep {
  std::uint64_t revision = 0;  ///< After the step.
  Clock::time_point first;     ///< Arrival of its first message.
  Clock::time_point last;      ///< Arrival of the progress.
  std::uint64_t bytes = 0;     ///< Of all its messages, serialized.
  std::uint32_t messages = 0;  ///< Including the progress.
};

/// Behaviour of a watcher.
struct WatcherPlan {
  v1::WatchMapRequest request;
  /// Stops reading after this many messages and keeps the call open; 0: never stops.
  std::size_t stalls_after = 0;
  bool keeps = false;  ///< Stores the messages in `WatcherRecord::messages`.
};

/// Measurements of a watcher.
struct WatcherRecord {
  std::vector<WatchedStep> steps;
  bool stalled = false;                        ///< It stopped reading, as planned.
  std::vector<v1::WatchMapResponse> messages;  ///< If `WatcherPlan::keeps`.
  std::string end;  ///< Reason of a premature end of the stream; or empty.
};

/// Many watchers over loopback, served by one thread. Messages are counted and dated by their first
/// bytes without parsing, so that a thousand watchers use little processor time compared with the
/// daemon.
class WatchCrowd {
 public:
  /// Opens `connections` connections (at least 1), distributes the watchers over them and waits
  /// until each has received its first message. Throws `std::runtime_error` if a watch ends
  /// instead.
  WatchCrowd(const std::string& address,
             std::size_t connections,
             const std::vector<WatcherPlan>& plans);
  ~WatchCrowd();

  WatchCrowd(const WatchCrowd&) = delete;
  WatchCrowd& operator=(const WatchCrowd&) = delete;

  /// Waits until every reading watcher has `revision`; false after `limit`.
  bool AwaitRevision(std::uint64_t revision, std::chrono::seconds limit);

  /// Ends all watches; returns the records in the order of the plans.
  std::vector<WatcherRecord> Finish();

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace steadymap::benchmarks

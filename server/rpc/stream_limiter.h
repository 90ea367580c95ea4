#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <string>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

namespace steadymap {

/// A response stream that a `StreamLimiter` supervises.
class LimitedStream {
 public:
  virtual ~LimitedStream() = default;

  using Clock = std::chrono::steady_clock;

  /// Ends the stream if at `now` a message has been pending for longer than `timeout`. Called from
  /// any thread, without locks held. Must not block.
  virtual void EndIfStalled(Clock::time_point now, Clock::duration timeout) = 0;
};

/// Limits the number of response streams, in total and per IP address, and ends streams whose
/// client does not read. Thread-safe.
class StreamLimiter {
 public:
  struct Limits {
    std::size_t max_streams = 64;
    std::size_t max_per_address = 8;
    /// A client that reads nothing for longer than this has stalled.
    LimitedStream::Clock::duration stall_timeout = LimitedStream::Clock::duration::max();
  };

  explicit StreamLimiter(const Limits& limits) : limits_(limits) {}

  /// Admits a stream. The stream must call `Leave` at its end. `peer` is the gRPC peer string of
  /// its client. Errors: `ResourceExhausted` with reason `QUEUE_FULL`.
  absl::Status Enter(const std::shared_ptr<LimitedStream>& stream, const std::string& peer)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Stops counting a stream that has begun to end. It is still checked for stalls until it leaves.
  void Discount(const std::shared_ptr<LimitedStream>& stream) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Removes a stream. Has no effect if the stream was not admitted.
  void Leave(const std::shared_ptr<LimitedStream>& stream) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends the streams that have stalled at `now`. Must be called periodically.
  void EndStalled(LimitedStream::Clock::time_point now) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the number of counted streams.
  std::size_t stream_count() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Entry {
    std::string address;
    bool counts = true;
  };

  void RemoveFromCount(Entry* entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Limits limits_;
  mutable absl::Mutex mutex_;
  std::map<std::shared_ptr<LimitedStream>, Entry> streams_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::size_t> count_by_address_ ABSL_GUARDED_BY(mutex_);
  std::size_t count_ ABSL_GUARDED_BY(mutex_) = 0;
};

/// Returns the part of a gRPC peer string that is common to all connections of a machine:
/// `ipv4:10.0.0.7` for `ipv4:10.0.0.7:51034`. All unix sockets share one address, and so do all
/// in-process channels.
std::string AddressOfPeer(const std::string& peer);

}  // namespace steadymap

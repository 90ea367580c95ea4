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

/// A stream of answers that a gate let in. Called from any thread, without locks held; returns at
/// once.
class LimitedStream {
 public:
  virtual ~LimitedStream() = default;

  using Clock = std::chrono::steady_clock;

  /// Ends the stream if at `now` a message has been on its way for longer than `timeout`.
  virtual void EndIfStalled(Clock::time_point now, Clock::duration timeout) = 0;
};

/// Lets streams in, so many in all and so many from one address, and ends those whose client does
/// not read. Thread-safe.
class StreamLimiter {
 public:
  struct Limits {
    std::size_t max_streams = 64;
    std::size_t max_per_address = 8;
    /// A client that takes nothing for longer than this has stalled.
    LimitedStream::Clock::duration stall_timeout = LimitedStream::Clock::duration::max();
  };

  explicit StreamLimiter(const Limits& limits) : limits_(limits) {}

  /// Lets a stream in, to leave again at its end; `peer` is what gRPC calls its client.
  /// Errors: `ResourceExhausted` with reason `QUEUE_FULL`.
  absl::Status Enter(const std::shared_ptr<LimitedStream>& stream, const std::string& peer)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// A stream whose end has begun no longer counts; it is watched until it leaves.
  void Discount(const std::shared_ptr<LimitedStream>& stream) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Forgets a stream; nothing happens if it was not let in.
  void Leave(const std::shared_ptr<LimitedStream>& stream) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends the streams that have stalled at `now`; to be called now and then.
  void EndStalled(LimitedStream::Clock::time_point now) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Streams that count.
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

/// The part of what gRPC calls a peer that all connections of its machine share: `ipv4:10.0.0.7` of
/// `ipv4:10.0.0.7:51034`. Unix sockets and channels within the process are one address each.
std::string AddressOfPeer(const std::string& peer);

}  // namespace steadymap

#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

#include <poll.h>

#include "tests/support/descriptor.h"

namespace steadymap {

/// One direction of a proxy's connection: bytes in transit between two sockets. Holds at most one
/// buffer. Not thread-safe.
class ProxyLane {
 public:
  using Clock = std::chrono::steady_clock;

  /// Does not own the sockets; both must be non-blocking.
  ProxyLane(int source, int destination) : source_(source), destination_(destination) {}

  /// Adds the allowance of the elapsed time at `bytes_per_second` (0: no limit).
  void Refill(Clock::time_point now, std::size_t bytes_per_second);

  /// True if the lane waits for bytes of its source, or for its destination to accept some.
  bool wants_source() const { return begin_ == end_ && !ended_ && allowance_ >= quantum_; }

  bool wants_destination() const { return begin_ < end_; }

  /// The time at which `wants_source` may become true; none if it will not by time alone.
  std::optional<Clock::time_point> next_refill() const;

  /// Moves all bytes that can be moved now; returns the number of bytes that the destination
  /// accepted, none if a socket failed.
  std::optional<std::size_t> Move();

  /// The source has ended, and the end was forwarded to the destination.
  bool ended() const { return ended_ && begin_ == end_; }

 private:
  bool Read();

  int source_;
  int destination_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool ended_ = false;  ///< The source sends no more.

  std::size_t rate_ = 0;      ///< Bytes per second; 0: no limit.
  double quantum_ = 0.0;      ///< Minimum number of bytes per system call.
  double allowance_ = 0.0;    ///< Bytes that may be read now; undefined without a limit.
  Clock::time_point filled_;  ///< Time of the last increase of the allowance.
};

/// A client's socket, the target's socket, and the bytes in transit between them. Not thread-safe.
class ProxyConnection {
 public:
  using Clock = ProxyLane::Clock;

  /// `target` may still be connecting. Both must be non-blocking.
  ProxyConnection(Descriptor client, Descriptor target);

  /// Appends two entries for poll(2): the client's and the target's. A socket without an expected
  /// event has the descriptor -1.
  void AppendPolled(std::vector<pollfd>* polled) const;

  void Refill(Clock::time_point now, std::size_t bytes_per_second);

  std::optional<Clock::time_point> next_refill() const;

  /// Result of a turn.
  struct Turn {
    std::size_t to_target_bytes = 0;
    std::size_t to_client_bytes = 0;
    bool over = false;  ///< Both have ended, or one failed and the other was reset.
  };

  /// Moves all bytes that can be moved, given the poll(2) results of the two entries.
  Turn Move(const pollfd& client, const pollfd& target);

  /// Resets both sides, like a router that lost the connection's state.
  void Reset();

 private:
  bool FinishConnecting();

  Descriptor client_;
  Descriptor target_;
  bool connected_ = false;
  ProxyLane to_target_;
  ProxyLane to_client_;
};

/// Closes a socket so that its peer receives a reset. Unsent bytes are lost.
void ResetSocket(Descriptor* socket);

}  // namespace steadymap

#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

#include <poll.h>

#include "tests/support/descriptor.h"

namespace steadymap {

/// One way of a proxy's connection: bytes on their way from one socket to another. Holds at most
/// one buffer of them. Not thread-safe.
class ProxyLane {
 public:
  using Clock = std::chrono::steady_clock;

  /// Neither socket is owned; both must not block.
  ProxyLane(int source, int destination) : source_(source), destination_(destination) {}

  /// Lets time pass on a lane of `bytes_per_second` (0: no limit).
  void Refill(Clock::time_point now, std::size_t bytes_per_second);

  /// Whether the lane waits for bytes of its source, or until its destination takes some.
  bool wants_source() const { return begin_ == end_ && !ended_ && allowance_ >= quantum_; }

  bool wants_destination() const { return begin_ < end_; }

  /// When `wants_source` may become true by time alone; none if it will not.
  std::optional<Clock::time_point> next_refill() const;

  /// Moves what can be moved now; answers how much the destination took, none if a socket failed.
  std::optional<std::size_t> Move();

  /// The source has ended, and the destination has been told.
  bool ended() const { return ended_ && begin_ == end_; }

 private:
  bool Read();

  int source_;
  int destination_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool ended_ = false;  ///< The source has said that it sends no more.

  std::size_t rate_ = 0;      ///< Bytes a second; 0: no limit.
  double quantum_ = 0.0;      ///< Fewer bytes than this are not worth a system call.
  double allowance_ = 0.0;    ///< Bytes that may be read now; meaningless without a limit.
  Clock::time_point filled_;  ///< When the allowance was last raised.
};

/// A client's socket and the target's, with what is on its way between them. Not thread-safe.
class ProxyConnection {
 public:
  using Clock = ProxyLane::Clock;

  /// `target` may be connecting still. Both must not block.
  ProxyConnection(Descriptor client, Descriptor target);

  /// What the connection waits for, as two entries for poll(2): the client's, the target's. A
  /// socket that it expects nothing of has -1.
  void AppendPolled(std::vector<pollfd>* polled) const;

  void Refill(Clock::time_point now, std::size_t bytes_per_second);

  std::optional<Clock::time_point> next_refill() const;

  /// What became of a turn.
  struct Turn {
    std::size_t to_target_bytes = 0;
    std::size_t to_client_bytes = 0;
    bool over = false;  ///< Both sides have ended, or one has failed and the other was reset.
  };

  /// Moves what can be moved, given what poll(2) found in the two entries.
  Turn Move(const pollfd& client, const pollfd& target);

  /// Resets both sides, as a router that forgot the connection does.
  void Reset();

 private:
  bool FinishConnecting();

  Descriptor client_;
  Descriptor target_;
  bool connected_ = false;
  ProxyLane to_target_;
  ProxyLane to_client_;
};

/// Closes a socket so that its peer sees a reset. What was not sent is lost.
void ResetSocket(Descriptor* socket);

}  // namespace steadymap

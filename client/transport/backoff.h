#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>

namespace steadymap {

/// Parameters of the delays between attempts.
struct BackoffOptions {
  std::chrono::milliseconds first_delay{100};  ///< Before the first retry.

  /// Longest delay, before jitter, after an attempt that a server answered.
  std::chrono::milliseconds max_delay{5'000};

  /// Longest delay, before jitter, after an attempt without an answer. It is shorter than
  /// `max_delay`: such an attempt costs no server time, and a long delay postpones the reconnection
  /// to a restarted server.
  std::chrono::milliseconds max_unanswered_delay{500};

  double factor = 2.0;  ///< Ratio of each delay to the previous one, >= 1.

  /// Each delay is multiplied by a random factor in [1 - jitter, 1 + jitter]; jitter is in [0, 1).
  /// Robots of a fleet lose their server at the same moment; jitter spreads their reconnections.
  double jitter = 0.5;

  /// Retrying ends after this time without a success.
  std::chrono::milliseconds give_up_after{60'000};
};

/// Result of a failed attempt, input of the next delay.
struct FailedTry {
  /// True if a server answered; false if it was unreachable or the connection broke.
  bool was_answered = true;
  std::chrono::milliseconds asked{0};  ///< Delay that the server requested.
  std::chrono::milliseconds took{0};  ///< Duration of the attempt, counted against `give_up_after`.
};

/// Computes exponentially growing, jittered delays. Uses no clock: the elapsed time is the sum of
/// the returned delays and of `FailedTry::took`.
class Backoff {
 public:
  /// Equal seeds give equal delays.
  Backoff(const BackoffOptions& options, std::uint64_t seed);

  /// Returns the next delay, or none once `give_up_after` has passed since the last success. The
  /// delay requested by the server is added to the jittered delay, so the clients of one server do
  /// not reconnect at the same moment.
  std::optional<std::chrono::milliseconds> NextDelay(const FailedTry& failed = {});

  /// Records a success: resets the delays and the time counted against `give_up_after`.
  void Reset();

  /// Records that a server was reached without a success: resets the time counted against
  /// `give_up_after`; the delays keep growing.
  void NoteReached() { waited_ms_ = 0.0; }

 private:
  BackoffOptions options_;
  std::mt19937_64 random_;
  double next_delay_ms_ = 0.0;
  double waited_ms_ = 0.0;
};

}  // namespace steadymap

#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>

namespace steadymap {

/// How long to wait between tries.
struct BackoffOptions {
  std::chrono::milliseconds first_delay{100};  ///< Before the first retry.

  /// No delay is longer, jitter aside, where a server had answered.
  std::chrono::milliseconds max_delay{5'000};

  /// No delay is longer, jitter aside, where none had: a try that nobody hears costs little, and
  /// who waits long between two comes back late to a server that is there again.
  std::chrono::milliseconds max_unanswered_delay{500};

  double factor = 2.0;  ///< Each delay against the one before, >= 1.

  /// Delays vary by this share of themselves, in [0, 1): a fleet's robots lose their server at the
  /// same moment, and must not all come back to it at the same moment.
  double jitter = 0.5;

  /// Without any success for this long, the retrying ends.
  std::chrono::milliseconds give_up_after{60'000};
};

/// What a try that failed says about the next one.
struct FailedTry {
  /// Whether a server answered; otherwise it was not reached, or went away.
  bool was_answered = true;
  std::chrono::milliseconds asked{0};  ///< The wait that the server asked for.
  std::chrono::milliseconds took{0};   ///< What the try took of the time to give up after.
};

/// Exponentially growing, jittered delays. Knows no clock: it counts the delays it gave, and what
/// tries are said to have taken.
class Backoff {
 public:
  /// Equal seeds give equal delays.
  Backoff(const BackoffOptions& options, std::uint64_t seed);

  /// The next delay, on top of what the server asked for, so that its clients do not all come back
  /// at once; none once the time since the last success is `give_up_after` or more.
  std::optional<std::chrono::milliseconds> NextDelay(const FailedTry& failed = {});

  /// Notes a success: the delays and the time to give up after start over.
  void Reset();

  /// Notes that there is a server, though nothing came of it: the time to give up after starts
  /// over, the delays go on growing.
  void NoteReached() { waited_ms_ = 0.0; }

 private:
  BackoffOptions options_;
  std::mt19937_64 random_;
  double next_delay_ms_ = 0.0;
  double waited_ms_ = 0.0;
};

}  // namespace steadymap

#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>

namespace steadymap {

/// How long to wait between tries.
struct BackoffOptions {
  std::chrono::milliseconds first_delay{100};  ///< Before the first retry.
  std::chrono::milliseconds max_delay{5'000};  ///< No delay is longer, jitter aside.
  double factor = 2.0;                         ///< Each delay against the one before, >= 1.
  double jitter = 0.2;  ///< Delays vary by this share of themselves, in [0, 1), so that a fleet's
                        ///< robots do not return to a restarted server all at once.
  /// Without any success for this long in delays, the retrying ends.
  std::chrono::milliseconds give_up_after{60'000};
};

/// Exponentially growing, jittered delays. Knows no clock: it counts the delays it gave.
class Backoff {
 public:
  /// Equal seeds give equal delays.
  Backoff(const BackoffOptions& options, std::uint64_t seed);

  /// The next delay, on top of what a server `asked` for, so that its clients do not all come back
  /// at once; none once the delays since the last success exceed `give_up_after`.
  std::optional<std::chrono::milliseconds> NextDelay(
      std::chrono::milliseconds asked = std::chrono::milliseconds(0));

  /// Notes a success: the delays start over.
  void Reset();

 private:
  BackoffOptions options_;
  std::mt19937_64 random_;
  double next_delay_ms_ = 0.0;
  double waited_ms_ = 0.0;
};

}  // namespace steadymap

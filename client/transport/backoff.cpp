#include "client/transport/backoff.h"

#include <algorithm>

namespace steadymap {
namespace {

double Milliseconds(std::chrono::milliseconds duration) {
  return static_cast<double>(duration.count());
}

}  // namespace

Backoff::Backoff(const BackoffOptions& options, std::uint64_t seed)
    : options_(options), random_(seed), next_delay_ms_(Milliseconds(options.first_delay)) {}

std::optional<std::chrono::milliseconds> Backoff::NextDelay(const FailedTry& failed) {
  waited_ms_ += Milliseconds(failed.took);
  if (waited_ms_ >= Milliseconds(options_.give_up_after)) return std::nullopt;
  const double longest_ms = Milliseconds(
      failed.was_answered ? options_.max_delay
                          : std::min(options_.max_delay, options_.max_unanswered_delay));
  std::uniform_real_distribution<double> share(1.0 - options_.jitter, 1.0 + options_.jitter);
  const double base_ms = std::min(next_delay_ms_, longest_ms);
  const double delay_ms = Milliseconds(failed.asked) + base_ms * share(random_);
  waited_ms_ += delay_ms;
  next_delay_ms_ = std::min(base_ms * options_.factor, longest_ms);
  return std::chrono::milliseconds(static_cast<std::int64_t>(delay_ms));
}

void Backoff::Reset() {
  next_delay_ms_ = Milliseconds(options_.first_delay);
  waited_ms_ = 0.0;
}

}  // namespace steadymap

#include "client/backoff.h"

#include <algorithm>

namespace steadymap {
namespace {

double Milliseconds(std::chrono::milliseconds duration) {
  return static_cast<double>(duration.count());
}

}  // namespace

Backoff::Backoff(const BackoffOptions& options, std::uint64_t seed)
    : options_(options), random_(seed), next_delay_ms_(Milliseconds(options.first_delay)) {}

std::optional<std::chrono::milliseconds> Backoff::NextDelay(std::chrono::milliseconds asked) {
  if (waited_ms_ >= Milliseconds(options_.give_up_after)) return std::nullopt;
  std::uniform_real_distribution<double> share(1.0 - options_.jitter, 1.0 + options_.jitter);
  const double delay_ms = Milliseconds(asked) + next_delay_ms_ * share(random_);
  waited_ms_ += delay_ms;
  next_delay_ms_ = std::min(next_delay_ms_ * options_.factor, Milliseconds(options_.max_delay));
  return std::chrono::milliseconds(static_cast<std::int64_t>(delay_ms));
}

void Backoff::Reset() {
  next_delay_ms_ = Milliseconds(options_.first_delay);
  waited_ms_ = 0.0;
}

}  // namespace steadymap

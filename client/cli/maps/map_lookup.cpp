#include "client/cli/maps/map_lookup.h"

#include <cstdint>
#include <optional>
#include <random>
#include <thread>

#include "client/cli/text/error_line.h"
#include "client/map/map_client.h"
#include "client/transport/backoff.h"
#include "client/transport/server_answer.h"

namespace steadymap {

std::chrono::milliseconds RetryTime(double retry_for_s) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * retry_for_s));
}

absl::StatusOr<v1::Map> LookUpMap(const MapName& name,
                                  std::chrono::milliseconds retry_for,
                                  CommandContext* context) {
  using Clock = std::chrono::steady_clock;
  Backoff backoff({.give_up_after = retry_for}, std::random_device()());
  for (bool has_said = false;; has_said = true) {
    const Clock::time_point start = Clock::now();
    absl::StatusOr<v1::Map> map = MapClient(context->Channel()).GetMap(name);
    if (map.ok() || IsServerAnswer(map.status())) return map;
    const auto took = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start);
    const std::optional<std::chrono::milliseconds> delay =
        backoff.NextDelay({.was_answered = false, .took = took});
    if (!delay) return map;
    if (!has_said) {
      context->err << ErrorLine(map.status(), context->server) << "; waiting for the server"
                   << std::endl;
    }
    std::this_thread::sleep_for(*delay);
  }
}

}  // namespace steadymap

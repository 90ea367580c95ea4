#include "client/bench/simulator/routes/named_routes.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include <absl/strings/numbers.h>

#include "client/bench/simulator/routes/clutter.h"
#include "client/bench/simulator/routes/large_hall.h"
#include "client/bench/simulator/routes/people.h"
#include "client/bench/simulator/routes/swapped_boxes_scene.h"
#include "client/bench/simulator/routes/table_top.h"
#include "client/bench/simulator/routes/torwic_hall.h"
#include "client/dataset/layouts/torwic_layout.h"
#include "core/types/absl_text.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::string_view kClutter = "clutter";

// Returns the sequence of TorWIC hall configurations of a route; empty for other routes.
std::vector<std::string> TorwicConfigurationsOf(std::string_view route) {
  if (route == "2-4-4") return {"2-2", "2-4", "4-1"};
  if (route == "9-2") return {"1-9", "2-1"};
  if (route == "unchanged") return {"baseline", "baseline"};
  const std::vector<std::string> known = TorwicConfigurations();
  if (std::find(known.begin(), known.end(), route) == known.end()) return {};
  if (route == "baseline") return {"baseline"};
  return {"baseline", std::string(route)};
}

absl::StatusOr<Route> MakeTorwicRoute(std::string_view name,
                                      const std::vector<std::string>& configurations) {
  Route route;
  route.name = name;
  route.camera = DefaultTorwicCalibration().camera;
  for (const std::string& configuration : configurations) {
    absl::StatusOr<Scene> scene = MakeTorwicHall(configuration);
    if (!scene.ok()) return scene.status();
    route.sequences.push_back({configuration, *std::move(scene), DriveTorwicLoop()});
  }
  return route;
}

/// Returns the seed of `clutter` or `clutter-SEED`; none for other names.
std::optional<std::uint64_t> ClutterSeedOf(std::string_view route) {
  if (!route.starts_with(kClutter)) return std::nullopt;
  route.remove_prefix(kClutter.size());
  if (route.empty()) return 1;
  std::uint64_t seed = 0;
  const bool is_seed = route.starts_with('-') && absl::SimpleAtoi(Absl(route.substr(1)), &seed);
  return is_seed ? std::optional(seed) : std::nullopt;
}

std::string Join(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

std::vector<std::string> RouteNames() {
  std::vector<std::string> names = TorwicConfigurations();
  for (const char* name :
       {"2-4-4", "9-2", "unchanged", "table-top", "twin", "people", "clutter", "hall"}) {
    names.emplace_back(name);
  }
  return names;
}

absl::StatusOr<Route> MakeRoute(std::string_view name) {
  if (name == "table-top") return MakeTableTopRoute();
  if (name == "twin") return MakeSwappedBoxesRoute();
  if (name == "people") return MakePeopleRoute();
  if (name == "hall") return MakeLargeHallRoute({});
  if (const auto seed = ClutterSeedOf(name)) return MakeClutterRoute(*seed);
  const std::vector<std::string> configurations = TorwicConfigurationsOf(name);
  if (!configurations.empty()) return MakeTorwicRoute(name, configurations);
  return InvalidField(reason::kBadName,
                      "route",
                      "unknown route \"" + std::string(name.substr(0, 80)) + "\"; the routes are " +
                          Join(RouteNames()));
}

}  // namespace steadymap

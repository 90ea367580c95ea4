#include "client/bench/evaluation/fleet/fleet_case.h"

namespace steadymap {
namespace {

constexpr double kDayS = 86400.0;

constexpr FleetCase kFleetCases[] = {
    {.name = "one-robot"},
    {.name = "2hz", .rate_hz = 2.0},
    {.name = "5hz", .rate_hz = 5.0},
    {.name = "15hz", .rate_hz = 15.0},
    {.name = "30hz", .rate_hz = 30.0},
    {.name = "pause-1s", .pause_s = 1.0},
    {.name = "pause-60s", .pause_s = 60.0},
    {.name = "pause-3d", .pause_s = 3.0 * kDayS},
    {.name = "one-upload-1s", .pause_s = 1.0, .is_one_upload = true},
    {.name = "newest-first", .is_newest_first = true},
    {.name = "newest-first-2", .is_newest_first = true, .has_past_of_second = true},
    {.name = "two-robots", .has_second_robot = true},
    {.name = "two-clocks", .second_ahead_s = 600.0, .has_second_robot = true},
    {.name = "two-clocks-5cm",
     .second_ahead_s = 600.0,
     .second_offset_m = 0.05,
     .has_second_robot = true},
    {.name = "offset-10cm", .second_offset_m = 0.1, .has_second_robot = true},
    {.name = "contradicting", .contradicting_drives = 3, .has_second_robot = true},
};

}  // namespace

std::span<const FleetCase> FleetCases() { return kFleetCases; }

std::vector<std::string> FleetCaseNames() {
  std::vector<std::string> names;
  for (const FleetCase& fleet_case : FleetCases()) names.emplace_back(fleet_case.name);
  return names;
}

Route RouteOf(const FleetCase& fleet_case, const Route& route) {
  Route changed = route;
  if (fleet_case.has_past_of_second) {
    changed.sequences.insert(changed.sequences.begin(), route.sequences.front());
  }
  for (int i = 0; i < fleet_case.contradicting_drives; ++i) {
    changed.sequences.push_back(route.sequences.back());
  }
  for (RouteSequence& sequence : changed.sequences) {
    if (fleet_case.rate_hz) sequence.trajectory.frame_period_s = 1.0 / *fleet_case.rate_hz;
    if (fleet_case.pause_s) sequence.pause_s = *fleet_case.pause_s;
  }
  return changed;
}

}  // namespace steadymap

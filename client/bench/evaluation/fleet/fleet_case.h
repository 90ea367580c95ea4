#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// How the frames of a route come to a map. By default, one robot drives the sequences in their
/// order, and rests in between.
struct FleetCase {
  std::string_view name;
  std::optional<double> rate_hz = std::nullopt;  ///< Of all frames; unset: the route's.
  std::optional<double> pause_s = std::nullopt;  ///< Between two sequences; unset: the route's.
  double second_ahead_s = 0.0;                   ///< Error of the clock of the second robot.
  /// Constant error of the poses of the second robot, along the x axis of the world.
  double second_offset_m = 0.0;
  /// Number of further drives of the last sequence in which the first robot sees the world as it
  /// was in the first sequence, and the second one as it is.
  int contradicting_drives = 0;
  bool has_second_robot = false;  ///< Every second frame is from it.
  bool is_one_upload = false;     ///< Nothing but the pause tells where a sequence ends.
  bool is_newest_first = false;   ///< The sequences arrive in the opposite order.
  /// All sequences but the last one are from the second robot, the first one twice.
  bool has_past_of_second = false;
};

/// All cases: the default one first.
std::span<const FleetCase> FleetCases();

/// Returns the names of all cases.
std::vector<std::string> FleetCaseNames();

/// Returns the route of a case.
Route RouteOf(const FleetCase& fleet_case, const Route& route);

}  // namespace steadymap

#pragma once

#include <string_view>
#include <vector>

#include "client/bench/simulator/scene/scene.h"

namespace steadymap {

/// A change of the TorWIC hall against its baseline.
struct TorwicScenario {
  std::string_view number;      ///< For example `2-1`.
  void (*apply)(Scene* scene);  ///< Changes a baseline hall; keeps the ids of remaining objects.
};

/// Returns the scenarios 1-1 to 4-1 in order. The hall already contains the objects that 2-2 and
/// 4-1 add when `apply` is called (see `MakeTorwicHall`).
const std::vector<TorwicScenario>& TorwicScenarios();

}  // namespace steadymap

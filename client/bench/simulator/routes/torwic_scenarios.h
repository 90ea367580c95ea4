#pragma once

#include <string_view>
#include <vector>

#include "client/bench/simulator/scene/scene.h"

namespace steadymap {

/// A change of the TorWIC hall against its baseline.
struct TorwicScenario {
  std::string_view number;      ///< Such as `2-1`.
  void (*apply)(Scene* scene);  ///< Changes a baseline hall; ids of what stays are kept.
};

/// The scenarios 1-1 to 4-1 in order. What 2-2 and 4-1 add is in the hall already when they are
/// applied (see `MakeTorwicHall`).
const std::vector<TorwicScenario>& TorwicScenarios();

}  // namespace steadymap

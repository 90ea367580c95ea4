#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// Returns every name that `MakeRoute` accepts, in the order of the documentation.
std::vector<std::string> RouteNames();

/// Builds a route by its name:
/// - `baseline`: one loop through the TorWIC hall; `unchanged`: two;
/// - `1-1` to `1-9`, `2-1` to `2-4`, `3-1` to `3-3`, `4-1`: `baseline`, then that scenario;
/// - `2-4-4`: scenarios 2-2, 2-4, 4-1; `9-2`: scenarios 1-9, 2-1;
/// - `unchanged`: `baseline` twice;
/// - `table-top`, `twin`, `people`, `hall`: the scenes of those names;
/// - `clutter` or `clutter-SEED`: a storeroom generated from the seed.
/// Errors: `InvalidArgument`, listing the valid names.
absl::StatusOr<Route> MakeRoute(std::string_view name);

}  // namespace steadymap

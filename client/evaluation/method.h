#pragma once

#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "core/map_config.h"

namespace steadymap {

/// A way to build a map, a row of the tables.
struct Method {
  std::string name;
  MapConfig config;
  bool last_sequence_only = false;  ///< Whether it is shown the last sequence alone.
};

/// Names of all methods, yardsticks first.
std::vector<std::string> MethodNames();

/// The methods with these names, in the order of `MethodNames`, and always the two yardsticks;
/// all methods if `names` is empty. `base` is what they have in common: all but the policy and its
/// switches.
/// Errors: `InvalidArgument`, listing the names there are.
absl::StatusOr<std::vector<Method>> SelectMethods(const std::vector<std::string>& names,
                                                  const MapConfig& base);

}  // namespace steadymap

#pragma once

#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "core/types/map_config.h"

namespace steadymap {

/// A method of building a map; one row of the tables.
struct Method {
  std::string name;
  MapConfig config;
  bool last_sequence_only = false;  ///< Integrates the last sequence only.
};

/// Returns the names of all methods, the two reference methods first.
std::vector<std::string> MethodNames();

/// Returns the methods with these names, in the order of `MethodNames`, and always the two
/// reference methods; all methods if `names` is empty. `base` is the common configuration without
/// the policy; each method takes the parameters that its policy has. Errors: `InvalidArgument` for
/// an unknown name, listing the valid ones, and for a parameter that no policy of these has; as
/// `ValidateMapConfig`.
absl::StatusOr<std::vector<Method>> SelectMethods(const std::vector<std::string>& names,
                                                  const MapConfig& base);

}  // namespace steadymap

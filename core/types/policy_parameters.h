#pragma once

#include <span>
#include <string>
#include <string_view>

#include <absl/status/status.h>

#include "core/types/map_config.h"

namespace steadymap {

/// A number of an update policy that the creator of a map can set.
struct PolicyParameter {
  std::string_view name;  ///< Lower case, with its unit; unique in its policy.
  double default_value = 0.0;
  double min = 0.0;
  double max = 0.0;
  bool is_whole = false;  ///< True if only whole numbers are valid.
  std::string_view description;
};

/// Returns the parameters of a policy; none for `static`.
std::span<const PolicyParameter> ParametersOf(UpdatePolicy policy);

/// Returns the parameter of that name; null if the policy has none.
const PolicyParameter* FindParameter(UpdatePolicy policy, std::string_view name);

/// Returns the value of a parameter of the configuration's policy: the one that is set, else the
/// default. The policy must have the parameter (asserted).
double ParameterValue(const MapConfig& config, std::string_view name);

/// Returns the names of a policy's parameters, separated by commas; `none` if there are none.
std::string ParameterNames(UpdatePolicy policy);

}  // namespace steadymap

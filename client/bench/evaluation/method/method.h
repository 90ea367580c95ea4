#pragma once

#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "core/policy/ablation.h"
#include "core/types/map_config.h"

namespace steadymap {

/// A method of building a map; one row of the tables.
struct Method {
  std::string name;
  MapConfig config;
  Ablation switches;                ///< Of the policy `pocd`.
  bool last_sequence_only = false;  ///< Integrates the last sequence only.
  /// With policy `pocd`: decides at the end of each sequence, see `MapperOptions`.
  bool decides_by_session = false;
};

/// Returns the names of all methods, the two reference methods first.
std::vector<std::string> MethodNames();

/// Returns the names of the ablation switches of `pocd`, and `all`.
std::vector<std::string> SwitchNames();

/// Returns the methods with these names, in the order of `MethodNames`, and always the two
/// reference methods; all methods if `names` is empty. `base` is the common configuration without
/// the policy and its switches. For each of `switched_off`, `pocd` is followed by a method `pocd
/// -NAME` with only that switch off; `all` means every switch, one at a time. Errors:
/// `InvalidArgument`, listing the valid names; also for switches without `pocd`.
absl::StatusOr<std::vector<Method>> SelectMethods(
    const std::vector<std::string>& names,
    const MapConfig& base,
    const std::vector<std::string>& switched_off = {});

}  // namespace steadymap

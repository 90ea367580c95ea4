#pragma once

#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "core/policy/ablation.h"
#include "core/types/map_config.h"

namespace steadymap {

/// A way to build a map, a row of the tables.
struct Method {
  std::string name;
  MapConfig config;
  Ablation switches;                ///< Of the policy `pocd`.
  bool last_sequence_only = false;  ///< Whether it is shown the last sequence alone.
};

/// Names of all methods, yardsticks first.
std::vector<std::string> MethodNames();

/// Names of the switches of `pocd`, and `all`.
std::vector<std::string> SwitchNames();

/// The methods with these names, in the order of `MethodNames`, and always the two yardsticks;
/// all methods if `names` is empty. `base` is what they have in common: all but the policy and its
/// switches. After `pocd` comes, for each of `switched_off`, a method `pocd -NAME` that has all
/// switches on but that one; `all` stands for all of them, each by itself.
/// Errors: `InvalidArgument`, listing the names there are; the same if there are switches without
/// `pocd`.
absl::StatusOr<std::vector<Method>> SelectMethods(
    const std::vector<std::string>& names,
    const MapConfig& base,
    const std::vector<std::string>& switched_off = {});

}  // namespace steadymap

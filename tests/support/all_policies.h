#pragma once

#include <array>

#include "core/map_config.h"

namespace steadymap::testing {

/// Every policy that a map can have.
inline constexpr std::array kAllPolicies = {UpdatePolicy::kStatic,
                                            UpdatePolicy::kVoxelChange,
                                            UpdatePolicy::kSubmapChange,
                                            UpdatePolicy::kTracking,
                                            UpdatePolicy::kPocd,
                                            UpdatePolicy::kPocdPaper};

}  // namespace steadymap::testing

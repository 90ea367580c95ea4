#pragma once

#include <array>

#include "core/types/map_config.h"

namespace steadymap::testing {

/// Every policy of a map.
inline constexpr std::array kAllPolicies = {UpdatePolicy::kStatic,
                                            UpdatePolicy::kVoxelChange,
                                            UpdatePolicy::kSubmapChange,
                                            UpdatePolicy::kTracking,
                                            UpdatePolicy::kPocd,
                                            UpdatePolicy::kPocdPaper};

}  // namespace steadymap::testing

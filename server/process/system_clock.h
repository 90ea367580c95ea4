#pragma once

#include "core/types/timestamp.h"

namespace steadymap {

/// Returns the current time of the server's clock.
Timestamp Now();

}  // namespace steadymap

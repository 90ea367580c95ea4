#pragma once

#include "core/timestamp.h"

namespace steadymap {

/// The present moment by the server's clock.
Timestamp Now();

}  // namespace steadymap

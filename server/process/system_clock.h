#pragma once

#include "core/types/timestamp.h"

namespace steadymap {

/// The present moment by the server's clock.
Timestamp Now();

}  // namespace steadymap

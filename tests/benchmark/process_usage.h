#pragma once

#include <sys/types.h>

namespace steadymap::benchmarks {

/// Resources used by a process so far.
struct ProcessUsage {
  double resident_mb = 0.0;       ///< Now; 10^6 bytes.
  double peak_resident_mb = 0.0;  ///< Maximum so far.
  double processor_s = 0.0;       ///< Of all threads, user and system.
};

/// Returns zeros for a process that does not exist.
ProcessUsage UsageOf(pid_t process);

}  // namespace steadymap::benchmarks

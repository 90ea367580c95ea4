#pragma once

#include <sys/types.h>

namespace steadymap::benchmarks {

/// What a process has used so far.
struct ProcessUsage {
  double resident_mb = 0.0;       ///< Now; 10^6 bytes.
  double peak_resident_mb = 0.0;  ///< The most so far.
  double processor_s = 0.0;       ///< Of all threads, user and system.
};

/// All zero for a process that there is not.
ProcessUsage UsageOf(pid_t process);

}  // namespace steadymap::benchmarks

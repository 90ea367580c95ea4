#include "server/process/system_clock.h"

#include <chrono>

namespace steadymap {

Timestamp Now() {
  return Timestamp::FromNanoseconds(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                        std::chrono::system_clock::now().time_since_epoch())
                                        .count());
}

}  // namespace steadymap

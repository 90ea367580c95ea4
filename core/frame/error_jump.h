#pragma once

#include <csetjmp>

namespace steadymap {

/// Runs calls into a C library that reports errors by a jump to `trap->jump`. Returns false after
/// such a jump. Stack frames between this function and the library's error callback must contain no
/// object with a destructor: they belong to the library and to the lambda `calls` only.
template <typename Trap, typename Calls>
bool Guard(Trap* trap, Calls calls) {
  if (setjmp(trap->jump) != 0) return false;
  calls();
  return true;
}

}  // namespace steadymap

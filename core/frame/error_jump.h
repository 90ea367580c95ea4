#pragma once

#include <csetjmp>

namespace steadymap {

/// Runs calls into a C library that reports errors by jumping to `trap->jump`; false if it did.
/// The frames between this function and the library's error callback must hold nothing that has a
/// destructor: they are the library's own and a lambda's.
template <typename Trap, typename Calls>
bool Guard(Trap* trap, Calls calls) {
  if (setjmp(trap->jump) != 0) return false;
  calls();
  return true;
}

}  // namespace steadymap

#pragma once

#include <functional>

namespace steadymap {

/// Whether nobody wants the result of the work at hand any more; once true, always true. Whoever
/// works long asks now and then, from the working thread, and stops. Empty: always wanted.
using CancelCheck = std::function<bool()>;

/// What `check` says; false where it is empty. Cost: that of a call, small beside work on a leaf.
inline bool IsCancelled(const CancelCheck& check) { return check && check(); }

}  // namespace steadymap

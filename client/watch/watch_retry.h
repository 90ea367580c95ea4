#pragma once

#include <absl/status/status.h>

namespace steadymap {

/// Action after the end of a stream.
enum class NextWatch {
  kEnd,     ///< The watch ends.
  kResume,  ///< Resumes after the last step.
  kAfresh,  ///< Starts again with a snapshot.
};

/// Returns the action after a stream ended with `status`, from the server or the connection.
///
/// Transient errors are retried, and so is OK, because a watch has no regular end. OUT_OF_RANGE,
/// and the rejection of a token issued by the server (`had_token`), lead to a snapshot if
/// `may_resync` is true. Errors that the caller must fix end the watch.
NextWatch NextWatchAfter(const absl::Status& status, bool may_resync, bool had_token);

}  // namespace steadymap

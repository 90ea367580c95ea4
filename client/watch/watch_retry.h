#pragma once

#include <absl/status/status.h>

namespace steadymap {

/// How a watch goes on when its stream has ended.
enum class NextWatch {
  kEnd,     ///< Not at all.
  kResume,  ///< Behind the last step.
  kAfresh,  ///< With a snapshot.
};

/// How it goes on after the status that the server, or the connection, ended the stream with.
///
/// What may heal is tried again, OK included: a watch has no end of its own. OUT_OF_RANGE, and a
/// token that the server gave and no longer takes (`had_token`), leave a snapshot, where one may
/// take the place of what the watcher has (`may_resync`). What the caller must mend ends the watch.
NextWatch NextWatchAfter(const absl::Status& status, bool may_resync, bool had_token);

}  // namespace steadymap

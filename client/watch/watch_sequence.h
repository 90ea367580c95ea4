#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include <absl/status/status.h>

#include "core/types/identifiers.h"
#include "core/types/timestamp.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// A step completed by a `progress` message.
struct WatchStep {
  Revision revision;
  Revision previous_revision;  ///< Before the step; equal if only the token is new.
  std::uint64_t commits = 0;   ///< As reported by the delta; 0 without one.
  bool is_snapshot = false;    ///< The step replaces the whole state.
  std::string resume_token;    ///< Resumes after the step.
  /// Capture time of the newest frame in the map; none before the first frame.
  std::optional<Timestamp> last_capture_time{};

  /// True if the map may have changed.
  bool IsNews() const { return is_snapshot || revision != previous_revision; }
};

/// Start of a stream of a watch.
enum class WatchOpening {
  kNow,
  kSnapshot,
  kResume,
};

/// Checks the messages of a watch against the protocol (watch_service.proto), over all streams of
/// one watcher, and records the resume position. Every message is untrusted until checked: order,
/// revisions, fragments, event numbers, tokens. The content of objects and leaves is not checked.
/// No I/O; for one thread.
class WatchSequence {
 public:
  /// `takes_resync`: true if the request allowed the server to resync.
  explicit WatchSequence(bool takes_resync) : takes_resync_(takes_resync) {}

  /// Begins a new stream. With `kResume` it may continue the step that the last stream left
  /// unfinished. `kNow` and `kSnapshot` reset all state.
  void BeginStream(WatchOpening opening);

  /// Checks the next message of the stream. Ignores unknown kinds. Errors: `Internal` for a
  /// protocol violation; the stream must be closed then.
  absl::Status Take(const v1::WatchMapResponse& message);

  /// The step completed by the last `progress`.
  const WatchStep& step() const { return step_; }

  /// Revision that the watcher has completely; none before the first message with a revision.
  std::optional<Revision> revision() const { return revision_; }

  /// Returns the token to resume with: within the current step if the server sent a token for it,
  /// else after the last `progress`; empty before the first.
  const std::string& resume_token() const {
    return part_token_.empty() ? step_.resume_token : part_token_;
  }

  /// True if `resume_token` refers to a position within a step, so that its parts must be kept.
  bool is_within_step() const { return !part_token_.empty(); }

  /// Drops the current step: the next stream resumes after the last complete step.
  void ForgetPart();

  /// Start of the stream. After `created`: `kSnapshot` if the stream should have continued a
  /// snapshot and begins a new one.
  WatchOpening opening() const { return opening_; }

  /// True if the stream continues the step that the last stream left unfinished.
  bool continues_step() const { return continues_step_; }

  /// Delay requested by the `goodbye` of this stream, in [0, 10 min]; none without a `goodbye`.
  std::optional<std::chrono::milliseconds> reconnect_after() const { return reconnect_after_; }

 private:
  enum class Phase {
    kOpening,     ///< Before the first message.
    kSnapshot,    ///< The snapshot is arriving.
    kFollowing,   ///< Steps are arriving.
    kMustResync,  ///< The server cannot continue from the watcher's revision.
    kEnding,      ///< The server sent a goodbye.
  };

  /// The step that is arriving.
  struct OpenStep {
    Revision revision;
    std::uint64_t commits = 0;
    std::uint32_t fragment = 0;  ///< The last one received; 0: none.
    std::uint32_t fragments = 0;
    EventNumber newest_event;
  };

  /// A step that a stream left unfinished, with tokens to resume within it.
  struct UnfinishedStep {
    Phase phase = Phase::kFollowing;
    std::optional<OpenStep> step;
  };

  absl::Status TakeInOrder(const v1::WatchMapResponse& message);
  absl::Status TakePartToken(const v1::WatchMapResponse& message);
  absl::Status TakeCreated(const v1::WatchCreated& created);
  absl::Status ContinueStep(const v1::WatchCreated& created);
  void ForgetAll();
  absl::Status TakeSnapshot(const v1::SnapshotChunk& snapshot) const;
  absl::Status TakeDelta(const v1::DeltaFragment& delta);
  absl::Status TakeEvents(const v1::EventBatch& batch);
  absl::Status TakeProgress(const v1::WatchProgress& progress);
  absl::Status TakeResync(const v1::WatchResync& resync);
  absl::Status TakeGoodbye(const v1::WatchGoodbye& goodbye);

  /// Checks that a step to `revision` may begin or continue.
  absl::Status CheckStep(const char* what, Revision revision);

  const bool takes_resync_;
  WatchOpening opening_ = WatchOpening::kNow;
  Phase phase_ = Phase::kOpening;
  std::optional<Revision> revision_;
  Revision snapshot_revision_;  ///< While a snapshot is arriving.
  std::optional<OpenStep> open_step_;
  std::string part_token_;                    ///< From the newest message of the current step.
  std::optional<UnfinishedStep> unfinished_;  ///< From the end of its stream to the next `created`.
  bool continues_step_ = false;
  WatchStep step_;
  EventNumber newest_event_;
  v1::WatchCreated created_;  ///< The newest one.
  std::optional<std::chrono::milliseconds> reconnect_after_;
};

}  // namespace steadymap

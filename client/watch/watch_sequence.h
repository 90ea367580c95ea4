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

/// What a `progress` made whole.
struct WatchStep {
  Revision revision;
  Revision previous_revision;  ///< What the watcher had; the same where only the token is new.
  std::uint64_t commits = 0;   ///< As the delta said; 0 without one.
  bool is_snapshot = false;    ///< All that the filter shows, in place of all before.
  std::string resume_token;    ///< Behind the step.
  /// Of the newest frame in the map; none as long as it has none.
  std::optional<Timestamp> last_capture_time{};

  /// Whether anything may have changed.
  bool IsNews() const { return is_snapshot || revision != previous_revision; }
};

/// How a stream of a watch was opened.
enum class WatchOpening {
  kNow,
  kSnapshot,
  kResume,
};

/// Holds what arrives on a watch against what the contract promises (watch_service.proto), over all
/// streams of one watcher, and knows where to go on. Every message is hostile until checked: its
/// place in the order, revisions, fragments, numbers of events, tokens. Their content is not looked
/// at. Pure; one thread.
class WatchSequence {
 public:
  /// `takes_resync`: whether it was said that the server may resync.
  explicit WatchSequence(bool takes_resync) : takes_resync_(takes_resync) {}

  /// A new stream begins. With `kResume` it may go on within the step that the last one left
  /// unfinished; with `kNow` and `kSnapshot` that is forgotten, and everything else.
  void BeginStream(WatchOpening opening);

  /// Checks the message that came next on the stream. Kinds that are not known are passed over.
  /// Errors: `Internal` for one that breaks the protocol; the stream is of no use then.
  absl::Status Take(const v1::WatchMapResponse& message);

  /// The step that the last `progress` made whole.
  const WatchStep& step() const { return step_; }

  /// What the watcher has, whole; none before the first word about it.
  std::optional<Revision> revision() const { return revision_; }

  /// Where to go on: within the step on its way where the server gave a token for that, else behind
  /// the last `progress`; empty before the first.
  const std::string& resume_token() const {
    return part_token_.empty() ? step_.resume_token : part_token_;
  }

  /// Whether that is within a step, so that its parts are to be kept.
  bool is_within_step() const { return !part_token_.empty(); }

  /// Gives up the step on its way: the next stream goes on behind the last whole one.
  void ForgetPart();

  /// How the stream was opened. Once `created` has come, `kSnapshot` for one that was to go on
  /// within a snapshot and begins a new one.
  WatchOpening opening() const { return opening_; }

  /// Whether the stream goes on within the step that the last one left unfinished.
  bool continues_step() const { return continues_step_; }

  /// What the `goodbye` of this stream asked for, in [0, 10 min]; none without one.
  std::optional<std::chrono::milliseconds> reconnect_after() const { return reconnect_after_; }

 private:
  enum class Phase {
    kOpening,     ///< Nothing came yet.
    kSnapshot,    ///< The snapshot comes.
    kFollowing,   ///< Steps come.
    kMustResync,  ///< What the watcher has is of no use to the server.
    kEnding,      ///< The server said goodbye.
  };

  /// The step that is on its way.
  struct OpenStep {
    Revision revision;
    std::uint64_t commits = 0;
    std::uint32_t fragment = 0;  ///< The last one that came; 0: none.
    std::uint32_t fragments = 0;
    EventNumber newest_event;
  };

  /// The step that a stream left unfinished, with tokens to go on within it.
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

  /// Whether a step to `revision` may begin or go on.
  absl::Status CheckStep(const char* what, Revision revision);

  const bool takes_resync_;
  WatchOpening opening_ = WatchOpening::kNow;
  Phase phase_ = Phase::kOpening;
  std::optional<Revision> revision_;
  Revision snapshot_revision_;  ///< While the snapshot comes.
  std::optional<OpenStep> open_step_;
  std::string part_token_;                    ///< Of the newest message of the step on its way.
  std::optional<UnfinishedStep> unfinished_;  ///< From its stream's end to the next `created`.
  bool continues_step_ = false;
  WatchStep step_;
  EventNumber newest_event_;
  v1::WatchCreated created_;  ///< The newest.
  std::optional<std::chrono::milliseconds> reconnect_after_;
};

}  // namespace steadymap

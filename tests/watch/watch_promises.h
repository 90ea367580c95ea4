#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/map/map_filter.h"
#include "tests/watch/map_history.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// Holds a watch to its seven promises, message by message, over any number of streams that resume
/// one another. What is broken is noted under the promise's name:
///
/// - **Ordered**: revisions and event numbers rise.
/// - **Unique**: no revision and no event comes twice.
/// - **Reliable**: none is missing: every step begins where the one before ended, and its events
///   are all that the filter lets pass.
/// - **Atomic**: a step is whole: its fragments are complete and of one revision, its events are
///   its own, and only then there is a token.
/// - **Resumable**: behind a token a stream goes on where the token says.
/// - **Bookmarkable**: at a progress the watcher has everything that the map had at its revision,
///   bit for bit.
/// - **Filtered**: nothing comes that the filter does not show, and what leaves it does not stay.
///
/// For one thread.
class WatchPromises {
 public:
  WatchPromises(const MapFilter& filter, const MapHistory* history, const VoxelScale& scale);

  /// How a stream begins. From now on only events can be held to their promises.
  enum class Begin { kSnapshot, kNow, kResumed, kWithinStep };

  /// A stream begins; resumed behind `progress()`, or behind `part_token()`.
  void BeginStream(Begin begin);

  /// A message of the stream. What a stream told after its last progress is void when it ends,
  /// unless the next one goes on within the step.
  void Take(const v1::WatchMapResponse& message);

  /// The token for going on within the step that has not been closed; empty without.
  const std::string& part_token() const { return part_token_; }

  /// The newest progress; none yet.
  const std::optional<v1::WatchProgress>& progress() const { return progress_; }

  /// What was broken, each entry beginning with the promise's name.
  const std::vector<std::string>& broken() const { return broken_; }

  std::size_t steps() const { return steps_; }

  std::size_t events() const { return events_told_; }

  std::size_t resyncs() const { return resyncs_; }

  std::size_t jumps() const { return jumps_; }  ///< Steps over several commits.

  std::size_t patches() const { return patches_; }  ///< Leaves that came as patches.

  std::size_t continued() const { return continued_; }  ///< Streams that went on within a step.

 private:
  void VoidStep();
  void TakeCreated(const v1::WatchCreated& created);
  void TakeWithinStep(const v1::WatchCreated& created);
  void TakeSnapshot(const v1::SnapshotChunk& chunk);
  void TakeDelta(const v1::DeltaFragment& fragment);
  void TakeEvents(const v1::EventBatch& batch);
  void TakeProgress(const v1::WatchProgress& progress);
  void TakeResync(const v1::WatchResync& resync);

  template <typename Objects, typename Leaves>
  void Put(const Objects& objects, const Leaves& leaves);
  void CheckShown(const WatchedContent& truth);
  void CheckEvents();
  void CheckTime(const v1::WatchProgress& progress);
  void Break(const char* promise, const std::string& what);

  const MapFilter filter_;
  const MapHistory* const history_;
  const VoxelScale scale_;
  MapReplay replay_;
  std::optional<v1::WatchProgress> progress_;
  std::vector<std::string> broken_;
  std::size_t steps_ = 0;
  std::size_t events_told_ = 0;
  std::size_t resyncs_ = 0;
  std::size_t jumps_ = 0;
  std::size_t patches_ = 0;
  std::size_t continued_ = 0;

  // Of the stream.
  Begin begin_ = Begin::kSnapshot;
  bool within_step_ = false;    ///< It is to go on within a step, if its `created` says so.
  std::uint64_t revision_ = 0;  ///< What the watcher has.
  bool expects_snapshot_ = false;
  bool may_repeat_ = false;  ///< The next progress may repeat the revision: nothing is new.
  WatchedContent content_;
  std::uint64_t settled_event_ = 0;  ///< The last one before the newest progress.

  // Of the step that has not been closed by a progress.
  WatchedContent next_;
  std::uint64_t step_revision_ = 0;  ///< 0: nothing has been told yet.
  std::uint32_t fragments_ = 0;
  std::uint32_t next_fragment_ = 1;
  std::vector<v1::ObjectEvent> events_;
  std::uint64_t last_event_ = 0;
  std::string part_token_;
};

}  // namespace steadymap

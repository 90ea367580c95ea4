#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/map/map_filter.h"
#include "tests/watch/map_history.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// Checks a watch against the seven promises of the watch protocol, message by message, over any
/// number of streams that resume one another. Violations are recorded under the promise's name:
///
/// - **Ordered**: revisions and event numbers increase.
/// - **Unique**: no revision and no event is sent twice.
/// - **Reliable**: nothing is missing: every step begins at the end of the previous one, and its
///   events are all events that pass the filter.
/// - **Atomic**: a step is complete: its fragments are complete and of one revision, its events are
///   its own, and the token comes last.
/// - **Resumable**: a stream with a token continues at the token's position.
/// - **Bookmarkable**: at a progress the watcher has the complete filtered map of its revision, bit
///   for bit.
/// - **Filtered**: nothing is sent that does not pass the filter, and objects that stop passing are
///   removed.
///
/// For one thread.
class WatchPromises {
 public:
  WatchPromises(const MapFilter& filter, const MapHistory* history, const VoxelScale& scale);

  /// Start of a stream. After `kNow` only events can be checked.
  enum class Begin { kSnapshot, kNow, kResumed, kWithinStep };

  /// Begins a stream; a resumed one continues after `progress()` or `part_token()`.
  void BeginStream(Begin begin);

  /// Checks a message of the stream. The content after the last progress is dropped at the end of
  /// the stream, unless the next stream continues the step.
  void Take(const v1::WatchMapResponse& message);

  /// Token to resume within the unfinished step; empty if there is none.
  const std::string& part_token() const { return part_token_; }

  /// The newest progress; none before the first.
  const std::optional<v1::WatchProgress>& progress() const { return progress_; }

  /// Violations, each beginning with the promise's name.
  const std::vector<std::string>& broken() const { return broken_; }

  std::size_t steps() const { return steps_; }

  std::size_t events() const { return events_told_; }

  std::size_t resyncs() const { return resyncs_; }

  std::size_t jumps() const { return jumps_; }  ///< Steps over several commits.

  std::size_t patches() const { return patches_; }  ///< Leaves received as patches.

  std::size_t continued() const { return continued_; }  ///< Streams that continued a step.

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

  // State of the stream.
  Begin begin_ = Begin::kSnapshot;
  bool within_step_ = false;    ///< It should continue a step, if `created` confirms it.
  std::uint64_t revision_ = 0;  ///< Revision of the watcher.
  bool expects_snapshot_ = false;
  bool may_repeat_ = false;  ///< The next progress may repeat the revision without changes.
  WatchedContent content_;
  std::uint64_t settled_event_ = 0;  ///< The last one before the newest progress.

  // State of the step that is not yet completed by a progress.
  WatchedContent next_;
  std::uint64_t step_revision_ = 0;  ///< 0: no message of the step yet.
  std::uint32_t fragments_ = 0;
  std::uint32_t next_fragment_ = 1;
  std::vector<v1::ObjectEvent> events_;
  std::uint64_t last_event_ = 0;
  std::string part_token_;
};

}  // namespace steadymap

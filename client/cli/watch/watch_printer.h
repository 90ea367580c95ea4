#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"
#include "client/cli/text/stop_signal.h"
#include "client/cli/watch/watch_lines.h"
#include "client/watch/watch_consumer.h"

namespace steadymap {

/// The end conditions of `steadymap watch`, and its token file.
struct WatchPrinterOptions {
  bool as_json = false;
  std::filesystem::path token_file;             ///< Empty: none.
  std::optional<std::uint64_t> until_revision;  ///< End when this revision is reached.
  std::optional<std::uint64_t> count;           ///< End after this number of steps.
};

/// Prints a watch step by step. The lines of a step are printed together when the step is complete;
/// then its token is stored. After a crash, only the last step may therefore be printed twice.
class WatchPrinter final : public WatchConsumer {
 public:
  /// `classes`, `context` and `stop` must outlive the printer. `stop` is notified at the end.
  WatchPrinter(WatchPrinterOptions options,
               const ClassNames* classes,
               CommandContext* context,
               StopSignal* stop);

  absl::Status Begin(const v1::WatchCreated& created, WatchOpening opening) override;
  absl::Status Resync(const v1::WatchResync& resync) override;
  absl::Status TakeSnapshot(const v1::SnapshotChunk& chunk) override;
  absl::Status TakeDelta(const v1::DeltaFragment& delta) override;
  absl::Status TakeEvents(const v1::EventBatch& batch) override;
  void Commit(const WatchStep& step) override;
  void Discard() override;
  void OnState(const WatchStateChange& change) override;

  /// True if no more output will be printed. Any thread.
  bool is_done() const;

  /// Returns OK if the watch ended as requested, or has not ended. Any thread.
  absl::Status result() const;

 private:
  void TakeLeaf(const v1::PackedLeaf& leaf);
  void Print(const std::string& lines);
  void End(const absl::Status& status);

  const WatchPrinterOptions options_;
  const WatchLines lines_;
  CommandContext* const context_;
  StopSignal* const stop_;

  // Used only on the thread of the watch.
  std::string step_lines_;  ///< Lines of the incomplete step.
  VolumeChange volume_;     ///< Changed leaves of the incomplete step.
  bool has_begun_ = false;
  std::string interruption_reason_;  ///< The reason of the last interruption.
  std::uint64_t steps_ = 0;

  mutable std::mutex mutex_;  ///< Guards the members below.
  bool is_done_ = false;
  absl::Status result_;
};

}  // namespace steadymap

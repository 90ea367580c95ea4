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

/// When `steadymap watch` ends by itself, and where it keeps its token.
struct WatchPrinterOptions {
  bool as_json = false;
  std::filesystem::path token_file;             ///< Empty: none.
  std::optional<std::uint64_t> until_revision;  ///< Once this one is reached.
  std::optional<std::uint64_t> count;           ///< After so many steps.
};

/// Prints what a watch brings, step by step: a step's lines appear together, once it is whole, and
/// then its token is kept. What may come twice after a crash is therefore the last step.
class WatchPrinter final : public WatchConsumer {
 public:
  /// `classes`, `context` and `stop`, which is notified at the end, must outlive the printer.
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

  /// Whether nothing more will be printed. Any thread.
  bool is_done() const;

  /// OK if it ended as asked, or has not ended. Any thread.
  absl::Status result() const;

 private:
  void TakeLeaf(const v1::PackedLeaf& leaf);
  void Print(const std::string& lines);
  void End(const absl::Status& status);

  const WatchPrinterOptions options_;
  const WatchLines lines_;
  CommandContext* const context_;
  StopSignal* const stop_;

  // Of the watch's thread alone.
  std::string step_lines_;  ///< Of the step that is on its way.
  VolumeChange volume_;     ///< Likewise.
  bool has_begun_ = false;
  std::string trouble_;  ///< The reason of the last trouble.
  std::uint64_t steps_ = 0;

  mutable std::mutex mutex_;  ///< Guards what follows.
  bool is_done_ = false;
  absl::Status result_;
};

}  // namespace steadymap

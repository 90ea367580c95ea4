#include "client/cli/watch/watch_printer.h"

#include <utility>

#include "client/cli/text/error_line.h"
#include "client/cli/text/number_text.h"
#include "client/cli/watch/resume_token.h"
#include "core/types/error.h"

namespace steadymap {

WatchPrinter::WatchPrinter(WatchPrinterOptions options,
                           const ClassNames* classes,
                           CommandContext* context,
                           StopSignal* stop)
    : options_(std::move(options)),
      lines_(classes, options_.as_json),
      context_(context),
      stop_(stop) {}

absl::Status WatchPrinter::Begin(const v1::WatchCreated& created, WatchOpening opening) {
  const Revision revision(created.revision());
  if (!has_begun_) {
    Print(lines_.Created(created));
  } else if (opening != WatchOpening::kResume) {
    step_lines_ += lines_.Resync(revision, interruption_reason_);
  }
  has_begun_ = true;
  const bool has_all = opening != WatchOpening::kSnapshot;
  if (has_all && options_.until_revision && revision.value() >= *options_.until_revision) {
    End(absl::OkStatus());
  }
  return absl::OkStatus();
}

absl::Status WatchPrinter::Resync(const v1::WatchResync& resync) {
  step_lines_ += lines_.Resync(Revision(resync.revision()), resync.reason());
  return absl::OkStatus();
}

absl::Status WatchPrinter::TakeSnapshot(const v1::SnapshotChunk& chunk) {
  for (const v1::Object& object : chunk.objects()) {
    step_lines_ += lines_.Object(Revision(chunk.revision()), object);
  }
  for (const v1::PackedLeaf& leaf : chunk.leaves()) TakeLeaf(leaf);
  return absl::OkStatus();
}

absl::Status WatchPrinter::TakeDelta(const v1::DeltaFragment& delta) {
  const Revision revision(delta.revision());
  for (const std::uint64_t id : delta.removed_object_ids()) {
    step_lines_ += lines_.Removed(revision, id);
  }
  for (const v1::Object& object : delta.objects()) {
    step_lines_ += lines_.Object(revision, object);
  }
  for (const v1::PackedLeaf& leaf : delta.leaves()) TakeLeaf(leaf);
  return absl::OkStatus();
}

absl::Status WatchPrinter::TakeEvents(const v1::EventBatch& batch) {
  for (const v1::ObjectEvent& event : batch.events()) step_lines_ += lines_.Event(event);
  return absl::OkStatus();
}

void WatchPrinter::TakeLeaf(const v1::PackedLeaf& leaf) {
  LeafCounts& counts = volume_[leaf.object_id()];
  ++(leaf.packed().empty() ? counts.gone : counts.changed);
}

void WatchPrinter::Commit(const WatchStep& step) {
  if (is_done()) return;
  if (!volume_.empty()) step_lines_ += lines_.Volume(step, volume_);
  Print(step_lines_ + lines_.Progress(step));
  Discard();
  if (is_done()) return;
  if (!options_.token_file.empty()) {
    const absl::Status status = WriteTokenFile(options_.token_file, step.resume_token);
    if (!status.ok()) return End(status);
  }
  if (step.IsNews()) ++steps_;
  const bool has_arrived =
      options_.until_revision && step.revision.value() >= *options_.until_revision;
  if (has_arrived || (options_.count && steps_ >= *options_.count)) End(absl::OkStatus());
}

void WatchPrinter::Discard() {
  step_lines_.clear();
  volume_.clear();
}

void WatchPrinter::OnState(const WatchStateChange& change) {
  if (is_done()) return;
  if (change.state == WatchState::kEnded) return End(change.status);
  if (change.state != WatchState::kReconnecting) return;
  interruption_reason_ = ReasonOf(change.status);
  if (interruption_reason_.empty())
    interruption_reason_ = absl::StatusCodeToString(change.status.code());
  context_->err << "the watch was interrupted (" << ErrorLine(change.status, context_->server)
                << "); retrying in "
                << DurationText(1e-3 * static_cast<double>(change.delay.count())) << std::endl;
}

bool WatchPrinter::is_done() const {
  const std::lock_guard lock(mutex_);
  return is_done_;
}

absl::Status WatchPrinter::result() const {
  const std::lock_guard lock(mutex_);
  return result_;
}

void WatchPrinter::Print(const std::string& lines) {
  if (is_done()) return;
  context_->out << lines << std::flush;
  if (!context_->out) End(absl::FailedPreconditionError("cannot write to standard output"));
}

void WatchPrinter::End(const absl::Status& status) {
  {
    const std::lock_guard lock(mutex_);
    if (is_done_) return;
    is_done_ = true;
    result_ = status;
  }
  stop_->Notify();
}

}  // namespace steadymap

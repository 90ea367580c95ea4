#include "server/mapping_thread.h"

#include <algorithm>
#include <exception>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/time/time.h>
#include <spdlog/spdlog.h>

#include "core/error.h"
#include "proto/convert_frame.h"
#include "server/system_clock.h"

namespace steadymap {
namespace {

absl::StatusOr<Frame> UnpackFrame(const LogFrame& logged, std::size_t label_limit) {
  v1::Frame message;
  const bool parsed = message.ParseFromString(logged.packed_frame);
  absl::StatusOr<Frame> frame = absl::DataLossError("it does not parse");
  if (parsed) frame = FromProto(message, logged.robot, label_limit);
  if (frame.ok()) return frame;
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("frame ",
                                logged.sequence.value(),
                                " of the log cannot be read: ",
                                frame.status().message()));
}

}  // namespace

MappingThread::MappingThread(Source source,
                             std::unique_ptr<Mapper> mapper,
                             Store* store,
                             const CommitOptions& options,
                             Listener listener)
    : source_(std::move(source)),
      mapper_(std::move(mapper)),
      store_(store),
      options_(options),
      listener_(std::move(listener)),
      integrated_(source_.snapshot.revision.value()),
      committed_(source_.snapshot.revision.value()),
      max_delay_ms_(options.max_delay.count()) {
  mapper_->Restore(source_.snapshot);
  thread_ = std::thread([this] { Run(); });
}

MappingThread::~MappingThread() { Stop(/*commit=*/false); }

void MappingThread::Push(std::vector<LoggedFrame> frames) {
  const absl::MutexLock lock(&mutex_);
  if (failed_) return;
  for (LoggedFrame& frame : frames) inbox_.push_back(std::move(frame));
}

void MappingThread::RequestCommit(MapSequence target) {
  const absl::MutexLock lock(&mutex_);
  requested_ = std::max(requested_, target);
}

void MappingThread::Stop(bool commit) {
  {
    const absl::MutexLock lock(&mutex_);
    if (stop_mode_ != StopMode::kDrop) stop_mode_ = commit ? StopMode::kCommit : StopMode::kDrop;
  }
  if (thread_.joinable()) thread_.join();
}

std::size_t MappingThread::waiting_frames() const {
  const absl::MutexLock lock(&mutex_);
  return inbox_.size();
}

void MappingThread::Run() {
  absl::Status status;
  try {
    status = IntegrateLog();
    if (status.ok()) status = IntegrateInbox();
    if (status.ok() && stop_mode() == StopMode::kCommit) status = Commit();
  } catch (const std::exception& error) {
    status = MakeError(absl::StatusCode::kInternal, reason::kInternal, error.what());
  }
  ended_ = true;
  if (status.ok()) return;
  spdlog::error("map {}: integration has stopped at frame {}: {}",
                source_.record.name.ToString(),
                mapper_->head().value(),
                std::string(status.message()));
  listener_.on_failure(status);
  // The frames that wait are in the log; their memory is needed.
  std::deque<LoggedFrame> dropped;
  const absl::MutexLock lock(&mutex_);
  failed_ = true;
  dropped.swap(inbox_);
}

absl::Status MappingThread::IntegrateLog() {
  const std::size_t label_limit = source_.record.config.label_limit();
  if (mapper_->head() < source_.log_head) {
    spdlog::info("map {}: integrating the log from frame {} to {}",
                 source_.record.name.ToString(),
                 mapper_->head().Next().value(),
                 source_.log_head.value());
  }
  while (mapper_->head() < source_.log_head && stop_mode() == StopMode::kRun) {
    // Piece by piece, so that no iterator of the store lives across a commit.
    std::vector<LogFrame> piece;
    absl::Status read = store_->ReadLog(
        source_.record.key, mapper_->head().Next(), [&piece, this](LogFrame logged) {
          piece.push_back(std::move(logged));
          return piece.size() < options_.max_frames ? absl::OkStatus()
                                                    : absl::CancelledError("enough");
        });
    if (!read.ok() && !absl::IsCancelled(read)) return read;
    if (piece.empty() || piece.front().sequence != mapper_->head().Next()) {
      return MakeError(
          absl::StatusCode::kDataLoss,
          reason::kChecksum,
          absl::StrCat("the log lacks frame ", mapper_->head().Next().value(), " of the map"));
    }
    for (const LogFrame& logged : piece) {
      if (logged.sequence > source_.log_head || stop_mode() != StopMode::kRun) break;
      const absl::StatusOr<Frame> frame = UnpackFrame(logged, label_limit);
      if (!frame.ok()) return frame.status();
      if (absl::Status status = IntegrateOne(logged.sequence, *frame); !status.ok()) return status;
    }
  }
  return absl::OkStatus();
}

absl::Status MappingThread::IntegrateInbox() {
  while (stop_mode() == StopMode::kRun) {
    heartbeat_.Beat();
    for (LoggedFrame& logged : TakeFrames()) {
      // Moved out of the list, so that its memory is given back at once.
      const LoggedFrame taken = std::move(logged);
      if (stop_mode() != StopMode::kRun) break;
      absl::Status status = IntegrateOne(taken.sequence, taken.frame);
      if (!status.ok()) return status;
    }
    if (absl::Status status = CommitIfDue(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status MappingThread::IntegrateOne(MapSequence sequence, const Frame& frame) {
  if (mapper_->uncommitted_frames() == 0) {
    commit_due_ = Heartbeat::Clock::now() + std::chrono::milliseconds(max_delay_ms_);
  }
  mapper_->Integrate(sequence, frame);
  heartbeat_.Beat();
  {
    const absl::MutexLock lock(&mutex_);
    integrated_ = sequence;
  }
  return CommitIfDue();
}

absl::Status MappingThread::CommitIfDue() { return IsCommitDue() ? Commit() : absl::OkStatus(); }

absl::Status MappingThread::Commit() {
  if (mapper_->uncommitted_frames() == 0) return absl::OkStatus();
  const std::size_t frames = mapper_->uncommitted_frames();
  MapCommit commit = mapper_->Commit();
  commit_due_ = Heartbeat::Clock::time_point::max();
  if (absl::Status status = store_->CommitRevision(source_.record.key, commit.delta, Now());
      !status.ok()) {
    return status;
  }
  {
    const absl::MutexLock lock(&mutex_);
    committed_ = MapSequence(commit.delta.to.value());
  }
  spdlog::debug("map {}: committed revision {}: {} frames, {} leaves",
                source_.record.name.ToString(),
                commit.delta.to.value(),
                frames,
                commit.delta.leaves.size());
  listener_.on_commit(std::move(commit.snapshot));
  heartbeat_.Beat();
  return absl::OkStatus();
}

std::vector<LoggedFrame> MappingThread::TakeFrames() {
  std::vector<LoggedFrame> taken;
  const Heartbeat::Clock::time_point now = Heartbeat::Clock::now();
  const Heartbeat::Clock::duration wait =
      std::min(commit_due_, now + Heartbeat::kMaxInterval) - now;
  const absl::MutexLock lock(&mutex_);
  mutex_.AwaitWithTimeout(absl::Condition(this, &MappingThread::HasWork), absl::FromChrono(wait));
  while (!inbox_.empty() && taken.size() < options_.max_frames) {
    taken.push_back(std::move(inbox_.front()));
    inbox_.pop_front();
  }
  return taken;
}

bool MappingThread::IsCommitDue() {
  if (mapper_->uncommitted_frames() == 0) return false;
  if (mapper_->uncommitted_frames() >= options_.max_frames) return true;
  if (Heartbeat::Clock::now() >= commit_due_) return true;
  const absl::MutexLock lock(&mutex_);
  return IsRequested();
}

bool MappingThread::IsRequested() const {
  return requested_ > committed_ && integrated_ >= requested_;
}

bool MappingThread::HasWork() const {
  return stop_mode_ != StopMode::kRun || !inbox_.empty() || IsRequested();
}

MappingThread::StopMode MappingThread::stop_mode() const {
  const absl::MutexLock lock(&mutex_);
  return stop_mode_;
}

}  // namespace steadymap

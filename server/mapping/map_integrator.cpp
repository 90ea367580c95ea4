#include "server/mapping/map_integrator.h"

#include <algorithm>
#include <exception>
#include <utility>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "core/types/error.h"
#include "core/types/parallel.h"
#include "proto/convert_frame.h"

namespace steadymap {
namespace {

// Duration of a step: long enough to make the cost of switching between maps negligible, short
// enough that maps on the same thread do not delay each other noticeably.
constexpr std::chrono::milliseconds kSlice{20};

// Delay before a commit that failed for lack of disk space is retried.
constexpr std::chrono::seconds kCommitRetry{1};

// Entries read from the log at a time, about one second of frames from several robots.
constexpr std::size_t kReadAheadEntries = 16;
constexpr std::size_t kReadAheadBytes = std::size_t{8} << 20;

// A map without frames for this long releases its working memory.
constexpr std::chrono::seconds kIdleDelay{10};

// Number of crashes during the integration of an entry after which the map is quarantined.
constexpr std::uint32_t kMaxCrashes = 2;

// Number and decoded bytes of log entries that are decoded in parallel. More entries would not use
// more cores, and every map that replays its log needs this much memory.
constexpr std::size_t kDecodedEntries = 4;
constexpr std::size_t kDecodedBytes = std::size_t{8} << 20;

/// A parsed log entry, before its images are decoded.
struct ParsedEntry {
  v1::Frame message;
  bool parses = true;

  absl::StatusOr<DurableEntry> Decode(LogEntry logged, const KnownLabels& labels) const {
    DurableEntry entry{logged.sequence, logged.kind, {}, std::move(logged.classes), {}};
    entry.frame.source = logged.source;
    if (logged.kind != LogEntryKind::kFrame) return entry;
    absl::StatusOr<Frame> frame = absl::DataLossError("its bytes are not a valid Frame message");
    if (parses) frame = FromProto(message, logged.source, labels);
    if (!frame.ok()) {
      return MakeError(absl::StatusCode::kDataLoss,
                       reason::kChecksum,
                       absl::StrCat("frame ",
                                    logged.sequence.value(),
                                    " of the log cannot be read: ",
                                    frame.status().message()));
    }
    entry.frame = *std::move(frame);
    return entry;
  }
};

}  // namespace

MapIntegrator::MapIntegrator(Store* store,
                             const MapClock* clock,
                             const CommitOptions& options,
                             OnCommit on_commit)
    : store_(store),
      clock_(clock),
      options_(options),
      on_commit_(std::move(on_commit)),
      max_delay_ms_(options.max_delay.count()) {}

absl::Status MapIntegrator::Start(const MapRecord& record, const StoredState& state) {
  absl::StatusOr<std::unique_ptr<Mapper>> mapper = Mapper::Create(record.config);
  if (!mapper.ok()) return mapper.status();
  record_ = record;
  mapper_ = *std::move(mapper);
  mapper_->Restore(state.snapshot);
  note_ = state.note;
  labels_ = std::make_unique<KnownLabels>(state.durable_classes);
  log_head_ = state.durable_head;
  read_ahead_.clear();
  decoded_.clear();
  details_ = {};
  unstored_.reset();
  commit_due_ = Clock::time_point::max();
  release_at_ = Clock::time_point::max();
  DropWaiting();
  if (mapper_->head() < log_head_) {
    spdlog::info("map {}: replaying the log from entry {} to {}",
                 record_.name.ToString(),
                 mapper_->head().Next().value(),
                 log_head_.value());
  }
  return absl::OkStatus();
}

MapCounts MapIntegrator::Count(const MapSnapshot& snapshot) {
  MapCounts counts = counter_.Count(snapshot);
  counts.memory_bytes += mapper_->surface_bytes();
  return counts;
}

MapIntegrator::StepResult MapIntegrator::Step() {
  absl::Status status;
  try {
    status = Advance();
  } catch (const std::exception& error) {
    note_->Fail();
    status = MakeError(absl::StatusCode::kInternal, reason::kInternal, error.what());
  }
  if (status.ok()) return {status, NextStep()};
  spdlog::error("map {}: integration stopped after entry {}: {}",
                record_.name.ToString(),
                mapper_->head().value(),
                std::string(status.message()));
  DropWaiting();
  return {status, Strand::Next::Never()};
}

absl::Status MapIntegrator::Advance() {
  if (unstored_ && Clock::now() < retry_at_) return absl::OkStatus();
  if (unstored_ || IsCommitDue()) {
    if (absl::Status status = Commit(); !status.ok()) return status;
  }
  if (Clock::now() >= release_at_) {
    mapper_->ReleaseFrameMemory();
    release_at_ = Clock::time_point::max();
  }
  const Clock::time_point end = Clock::now() + kSlice;
  while (!unstored_ && !interrupted_ && Clock::now() < end) {
    absl::StatusOr<std::optional<DurableEntry>> entry = TakeEntry();
    if (!entry.ok()) return entry.status();
    if (!entry->has_value()) break;
    if (absl::Status status = Integrate(**entry); !status.ok()) return status;
    if (!IsCommitDue()) continue;
    if (absl::Status status = Commit(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

/// Returns the next entry: from the log until all entries up to `log_head_` are integrated, then
/// from the inbox.
absl::StatusOr<std::optional<DurableEntry>> MapIntegrator::TakeEntry() {
  if (mapper_->head() < log_head_) {
    if (decoded_.empty()) {
      if (absl::Status status = DecodeAhead(); !status.ok()) return status;
    }
    absl::StatusOr<DurableEntry> logged = std::move(decoded_.front());
    decoded_.pop_front();
    if (!logged.ok()) return logged.status();
    return std::optional<DurableEntry>(*std::move(logged));
  }
  std::optional<DurableEntry> entry;
  const absl::MutexLock lock(&mutex_);
  while (!inbox_.empty() && !entry) {
    // Entries appended during a reopening are both in the inbox and in the log.
    if (inbox_.front().sequence > mapper_->head()) entry = std::move(inbox_.front());
    inbox_.pop_front();
  }
  return entry;
}

/// Decodes the next entries of the log in parallel, as many as fit.
absl::Status MapIntegrator::DecodeAhead() {
  if (read_ahead_.empty()) {
    if (absl::Status status = ReadAhead(); !status.ok()) return status;
  }
  std::vector<ParsedEntry> parsed;
  std::size_t bytes = 0;
  while (parsed.size() < std::min(kDecodedEntries, read_ahead_.size()) && bytes < kDecodedBytes) {
    const LogEntry& entry = read_ahead_[parsed.size()];
    ParsedEntry& next = parsed.emplace_back();
    if (entry.kind != LogEntryKind::kFrame) continue;
    next.parses = next.message.ParseFromString(entry.packed_frame);
    bytes += DecodedBytes(next.message);
  }
  decoded_.resize(parsed.size());
  ParallelFor(parsed.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      decoded_[i] = parsed[i].Decode(std::move(read_ahead_[i]), *labels_);
    }
  });
  read_ahead_.erase(read_ahead_.begin(),
                    read_ahead_.begin() + static_cast<std::ptrdiff_t>(parsed.size()));
  return absl::OkStatus();
}

/// Reads a limited number of entries, so that no file of the store stays open during a commit.
absl::Status MapIntegrator::ReadAhead() {
  const MapSequence first = mapper_->head().Next();
  std::size_t bytes = 0;
  absl::Status read = store_->ReadLog(record_.key, first, [&](LogEntry entry) {
    bytes += entry.packed_frame.size();
    read_ahead_.push_back(std::move(entry));
    const bool enough = read_ahead_.size() >= kReadAheadEntries || bytes >= kReadAheadBytes;
    return enough ? absl::CancelledError("enough") : absl::OkStatus();
  });
  if (!read.ok() && !absl::IsCancelled(read)) return read;
  if (!read_ahead_.empty() && read_ahead_.front().sequence == first) return absl::OkStatus();
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("the log does not contain entry ", first.value(), " of the map"));
}

absl::Status MapIntegrator::Integrate(const DurableEntry& entry) {
  if (absl::Status status = CheckSuspect(entry.sequence); !status.ok()) return status;
  if (mapper_->uncommitted_entries() == 0) {
    commit_due_ = Clock::now() + std::chrono::milliseconds(max_delay_ms_);
  }
  release_at_ = Clock::now() + kIdleDelay;
  note_->Begin(entry.sequence);
  if (entry.kind == LogEntryKind::kClasses) {
    mapper_->AddClasses(entry.sequence, entry.classes);
  } else if (entry.kind == LogEntryKind::kSkipped) {
    mapper_->Skip(entry.sequence);
  } else if (entry.kind == LogEntryKind::kSessionEnd) {
    mapper_->EndSession(entry.sequence, entry.frame.source);
  } else {
    mapper_->Integrate(entry.sequence, entry.frame);
    details_.poses.push_back(
        {entry.sequence, entry.frame.source, entry.frame.capture_time, entry.frame.T_world_camera});
  }
  note_->End();
  return absl::OkStatus();
}

/// If a process crashed on this entry before, first commits all earlier entries.
absl::Status MapIntegrator::CheckSuspect(MapSequence sequence) {
  const std::optional<IntegrationNote::Suspect>& suspect = note_->suspect();
  if (!suspect || suspect->sequence != sequence) return absl::OkStatus();
  if (absl::Status status = Commit(); !status.ok()) return status;
  if (suspect->crashes < kMaxCrashes) return absl::OkStatus();
  return MakeError(
      absl::StatusCode::kFailedPrecondition,
      reason::kMapQuarantined,
      absl::StrCat("the server crashed or failed ",
                   suspect->crashes,
                   " times in a row during the integration of entry ",
                   sequence.value(),
                   " of the log; the map accepts no frames until this entry is skipped: stop the "
                   "server and run `steadymapd salvage --data-dir DIR --map ",
                   record_.name.ToString(),
                   " --skip-entry ",
                   sequence.value(),
                   "`"));
}

absl::Status MapIntegrator::CommitNow() {
  if (mapper_ == nullptr) return absl::OkStatus();
  return Commit();
}

absl::Status MapIntegrator::Commit() {
  if (!unstored_) {
    if (mapper_->uncommitted_entries() == 0) return absl::OkStatus();
    unstored_ = mapper_->Commit();
    commit_due_ = Clock::time_point::max();
  }
  details_.uptime = clock_->Now();
  const absl::StatusOr<CommitMark> mark =
      store_->CommitRevision(record_.key, unstored_->delta, details_);
  if (ReasonOf(mark.status()) == reason::kDiskLow) {
    retry_at_ = Clock::now() + kCommitRetry;
    return absl::OkStatus();
  }
  if (!mark.ok()) return mark.status();
  spdlog::debug("map {}: committed revision {}: {} frames, {} leaves",
                record_.name.ToString(),
                mark->revision.value(),
                details_.poses.size(),
                unstored_->delta.leaves.size());
  PublishedRevision published{std::move(unstored_->snapshot), *mark, {}};
  published.counts = Count(*published.snapshot);
  unstored_.reset();
  details_.poses.clear();
  on_commit_(std::move(published));
  return absl::OkStatus();
}

Strand::Next MapIntegrator::NextStep() const {
  if (unstored_) return Strand::Next::At(retry_at_);
  if (mapper_->head() < log_head_) return Strand::Next::Now();
  {
    const absl::MutexLock lock(&mutex_);
    if (!inbox_.empty()) return Strand::Next::Now();
  }
  if (mapper_->uncommitted_entries() > 0) return Strand::Next::At(commit_due_);
  return release_at_ == Clock::time_point::max() ? Strand::Next::Never()
                                                 : Strand::Next::At(release_at_);
}

bool MapIntegrator::IsCommitDue() const {
  if (mapper_->uncommitted_entries() == 0) return false;
  if (mapper_->uncommitted_entries() >= options_.max_frames) return true;
  if (Clock::now() >= commit_due_) return true;
  const MapSequence committed(mapper_->head().value() - mapper_->uncommitted_entries());
  const absl::MutexLock lock(&mutex_);
  return requested_ > committed && requested_ <= mapper_->head();
}

void MapIntegrator::Push(std::vector<DurableEntry> entries) {
  const absl::MutexLock lock(&mutex_);
  for (DurableEntry& entry : entries) inbox_.push_back(std::move(entry));
}

void MapIntegrator::RequestCommit(MapSequence target) {
  const absl::MutexLock lock(&mutex_);
  requested_ = std::max(requested_, target);
}

void MapIntegrator::DropWaiting() {
  std::deque<DurableEntry> dropped;
  const absl::MutexLock lock(&mutex_);
  dropped.swap(inbox_);
}

std::size_t MapIntegrator::waiting_entries() const {
  const absl::MutexLock lock(&mutex_);
  return inbox_.size();
}

}  // namespace steadymap

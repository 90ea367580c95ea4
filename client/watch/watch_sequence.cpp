#include "client/watch/watch_sequence.h"

#include <algorithm>
#include <cmath>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "proto/convert_geometry.h"

namespace steadymap {
namespace {

constexpr std::size_t kMaxTokenBytes = 256;
constexpr std::int64_t kMaxReconnectAfterS = 600;

template <typename... Parts>
absl::Status BrokenProtocol(const Parts&... parts) {
  return MakeError(absl::StatusCode::kInternal,
                   reason::kInternal,
                   absl::StrCat("the server broke the protocol of the watch: ", parts...));
}

bool IsLength(double length_m) { return std::isfinite(length_m) && length_m > 0.0; }

bool IsSameMap(const v1::WatchCreated& a, const v1::WatchCreated& b) {
  return a.incarnation() == b.incarnation() && a.voxel_size_m() == b.voxel_size_m() &&
         a.truncation_m() == b.truncation_m();
}

}  // namespace

void WatchSequence::BeginStream(WatchOpening opening) {
  // If the last stream ended before `created`, the step it should have continued stays stored.
  if (is_within_step() && !unfinished_) unfinished_ = UnfinishedStep{phase_, open_step_};
  opening_ = opening;
  phase_ = Phase::kOpening;
  open_step_.reset();
  reconnect_after_.reset();
  continues_step_ = false;
  if (opening != WatchOpening::kResume) ForgetAll();
}

void WatchSequence::ForgetAll() {
  revision_.reset();
  step_ = WatchStep();
  newest_event_ = EventNumber();
  ForgetPart();
}

void WatchSequence::ForgetPart() {
  part_token_.clear();
  unfinished_.reset();
}

absl::Status WatchSequence::Take(const v1::WatchMapResponse& message) {
  absl::Status status = TakeInOrder(message);
  return status.ok() ? TakePartToken(message) : status;
}

absl::Status WatchSequence::TakePartToken(const v1::WatchMapResponse& message) {
  switch (message.kind_case()) {
    case v1::WatchMapResponse::kSnapshot:
      part_token_ = message.snapshot().resume_token();
      break;
    case v1::WatchMapResponse::kDelta:
      part_token_ = message.delta().resume_token();
      break;
    case v1::WatchMapResponse::kEvents:
      part_token_ = message.events().resume_token();
      break;
    case v1::WatchMapResponse::kProgress:
    case v1::WatchMapResponse::kResync:
    case v1::WatchMapResponse::kGoodbye:
      part_token_.clear();
      break;
    default:
      break;
  }
  if (part_token_.size() <= kMaxTokenBytes) return absl::OkStatus();
  return BrokenProtocol("a resume token of ", part_token_.size(), " bytes");
}

absl::Status WatchSequence::TakeInOrder(const v1::WatchMapResponse& message) {
  const v1::WatchMapResponse::KindCase kind = message.kind_case();
  if (kind == v1::WatchMapResponse::KIND_NOT_SET) {
    // A message kind of a newer server; not requested.
    return absl::OkStatus();
  }
  if (phase_ == Phase::kEnding) return BrokenProtocol("a message came after the goodbye");
  if ((phase_ == Phase::kOpening) != (kind == v1::WatchMapResponse::kCreated)) {
    return BrokenProtocol("`created` must come first, and once");
  }
  switch (kind) {
    case v1::WatchMapResponse::kCreated:
      return TakeCreated(message.created());
    case v1::WatchMapResponse::kSnapshot:
      return TakeSnapshot(message.snapshot());
    case v1::WatchMapResponse::kDelta:
      return TakeDelta(message.delta());
    case v1::WatchMapResponse::kEvents:
      return TakeEvents(message.events());
    case v1::WatchMapResponse::kProgress:
      return TakeProgress(message.progress());
    case v1::WatchMapResponse::kResync:
      return TakeResync(message.resync());
    default:
      return TakeGoodbye(message.goodbye());
  }
}

absl::Status WatchSequence::TakeCreated(const v1::WatchCreated& created) {
  if (!IsLength(created.voxel_size_m()) || !IsLength(created.truncation_m())) {
    return BrokenProtocol("invalid voxel size or truncation");
  }
  if (created.continues_step()) return ContinueStep(created);
  if (unfinished_) {
    const bool was_snapshot = unfinished_->phase == Phase::kSnapshot;
    ForgetPart();
    if (was_snapshot) {
      ForgetAll();
      opening_ = WatchOpening::kSnapshot;
    }
  }
  const Revision revision(created.revision());
  if (opening_ == WatchOpening::kSnapshot) {
    phase_ = Phase::kSnapshot;
    snapshot_revision_ = revision;
  } else if (revision_ && (*revision_ != revision || !IsSameMap(created, created_))) {
    phase_ = Phase::kMustResync;
  } else {
    phase_ = Phase::kFollowing;
    revision_ = revision;
  }
  created_ = created;
  return absl::OkStatus();
}

absl::Status WatchSequence::ContinueStep(const v1::WatchCreated& created) {
  if (!unfinished_) return BrokenProtocol("it continues a step, but none is unfinished");
  const bool is_snapshot = unfinished_->phase == Phase::kSnapshot;
  const Revision due = is_snapshot ? snapshot_revision_ : revision_.value_or(Revision());
  if (Revision(created.revision()) != due || !IsSameMap(created, created_)) {
    return BrokenProtocol("it continues another step than the one at revision ", due.value());
  }
  phase_ = unfinished_->phase;
  open_step_ = unfinished_->step;
  unfinished_.reset();
  continues_step_ = true;
  created_ = created;
  return absl::OkStatus();
}

absl::Status WatchSequence::TakeSnapshot(const v1::SnapshotChunk& snapshot) const {
  if (phase_ != Phase::kSnapshot) {
    return BrokenProtocol("a snapshot came that was neither requested nor announced");
  }
  if (Revision(snapshot.revision()) != snapshot_revision_) {
    return BrokenProtocol("a part of the snapshot at revision ",
                          snapshot_revision_.value(),
                          " is of revision ",
                          snapshot.revision());
  }
  return absl::OkStatus();
}

absl::Status WatchSequence::CheckStep(const char* what, Revision revision) {
  if (phase_ == Phase::kMustResync) {
    return BrokenProtocol("it continues another map or revision than the watcher's revision ",
                          revision_->value());
  }
  if (phase_ != Phase::kFollowing) return BrokenProtocol(what, " came within a snapshot");
  if (revision <= *revision_) {
    return BrokenProtocol(
        what, " of revision ", revision.value(), " came after revision ", revision_->value());
  }
  if (!open_step_) open_step_ = OpenStep{.revision = revision, .newest_event = newest_event_};
  if (open_step_->revision != revision) {
    return BrokenProtocol(what,
                          " of revision ",
                          revision.value(),
                          " came within the step to revision ",
                          open_step_->revision.value());
  }
  return absl::OkStatus();
}

absl::Status WatchSequence::TakeDelta(const v1::DeltaFragment& delta) {
  if (absl::Status status = CheckStep("a delta", Revision(delta.revision())); !status.ok()) {
    return status;
  }
  if (Revision(delta.previous_revision()) != *revision_) {
    return BrokenProtocol("a delta continues revision ",
                          delta.previous_revision(),
                          ", but the watcher has revision ",
                          revision_->value());
  }
  const bool is_first = open_step_->fragment == 0;
  if (delta.fragment() != open_step_->fragment + 1 || delta.fragment() > delta.fragments() ||
      (!is_first && delta.fragments() != open_step_->fragments)) {
    return BrokenProtocol("fragment ",
                          delta.fragment(),
                          " of ",
                          delta.fragments(),
                          " came after fragment ",
                          open_step_->fragment,
                          " of ",
                          open_step_->fragments);
  }
  open_step_->fragment = delta.fragment();
  open_step_->fragments = delta.fragments();
  open_step_->commits = delta.commits();
  return absl::OkStatus();
}

absl::Status WatchSequence::TakeEvents(const v1::EventBatch& batch) {
  const Revision revision(batch.revision());
  if (absl::Status status = CheckStep("events", revision); !status.ok()) return status;
  for (const v1::ObjectEvent& event : batch.events()) {
    if (EventNumber(event.number()) <= open_step_->newest_event) {
      return BrokenProtocol(
          "event ", event.number(), " came after event ", open_step_->newest_event.value());
    }
    if (Revision(event.revision()) <= *revision_ || Revision(event.revision()) > revision) {
      return BrokenProtocol("an event of revision ",
                            event.revision(),
                            " came in the step from revision ",
                            revision_->value(),
                            " to ",
                            revision.value());
    }
    open_step_->newest_event = EventNumber(event.number());
  }
  return absl::OkStatus();
}

absl::Status WatchSequence::TakeProgress(const v1::WatchProgress& progress) {
  const Revision revision(progress.revision());
  if (progress.resume_token().empty() || progress.resume_token().size() > kMaxTokenBytes) {
    return BrokenProtocol("a resume token of ", progress.resume_token().size(), " bytes");
  }
  const bool is_snapshot = phase_ == Phase::kSnapshot;
  if (is_snapshot && revision != snapshot_revision_) {
    return BrokenProtocol("the snapshot at revision ",
                          snapshot_revision_.value(),
                          " ended with the progress to revision ",
                          revision.value());
  }
  if (!is_snapshot && (phase_ == Phase::kMustResync || revision != *revision_ || open_step_)) {
    if (absl::Status status = CheckStep("progress", revision); !status.ok()) return status;
    if (open_step_->fragment != open_step_->fragments) {
      return BrokenProtocol("the progress to revision ",
                            revision.value(),
                            " came after fragment ",
                            open_step_->fragment,
                            " of ",
                            open_step_->fragments);
    }
  }
  std::optional<Timestamp> last_capture_time;
  if (progress.has_last_capture_time()) {
    const absl::StatusOr<Timestamp> time = FromProto(progress.last_capture_time());
    if (!time.ok()) return BrokenProtocol("invalid capture time: ", time.status().message());
    last_capture_time = *time;
  }
  step_ = {.revision = revision,
           .previous_revision = revision_.value_or(revision),
           .commits = open_step_ ? open_step_->commits : 0,
           .is_snapshot = is_snapshot,
           .resume_token = progress.resume_token(),
           .last_capture_time = last_capture_time};
  if (open_step_) newest_event_ = open_step_->newest_event;
  phase_ = Phase::kFollowing;
  revision_ = revision;
  open_step_.reset();
  return absl::OkStatus();
}

absl::Status WatchSequence::TakeResync(const v1::WatchResync& resync) {
  if (!takes_resync_) return BrokenProtocol("a resync came that was not requested");
  phase_ = Phase::kSnapshot;
  snapshot_revision_ = Revision(resync.revision());
  open_step_.reset();
  newest_event_ = EventNumber();
  return absl::OkStatus();
}

absl::Status WatchSequence::TakeGoodbye(const v1::WatchGoodbye& goodbye) {
  const google::protobuf::Duration& wait = goodbye.reconnect_after();
  const std::int64_t seconds = std::clamp<std::int64_t>(wait.seconds(), 0, kMaxReconnectAfterS);
  const std::int64_t milliseconds = 1000 * seconds + std::max(wait.nanos(), 0) / 1'000'000;
  reconnect_after_ = std::chrono::milliseconds(std::min(milliseconds, 1000 * kMaxReconnectAfterS));
  phase_ = Phase::kEnding;
  return absl::OkStatus();
}

}  // namespace steadymap

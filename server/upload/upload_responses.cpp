#include "server/upload/upload_responses.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "proto/convert_status.h"

namespace steadymap {
namespace {

constexpr std::size_t kReceived = 0;
constexpr std::size_t kDurable = 1;
constexpr std::size_t kIntegrated = 2;

constexpr std::array kWireLevels = {
    v1::ACK_LEVEL_RECEIVED, v1::ACK_LEVEL_DURABLE, v1::ACK_LEVEL_INTEGRATED};

}  // namespace

v1::RefusedFrame ToProto(const RefusedFrame& refused) {
  v1::RefusedFrame message;
  message.set_client_seq(refused.sequence.value());
  *message.mutable_status() = ToProto(refused.status);
  return message;
}

absl::Status UploadResponses::ChooseLevels(const v1::UploadOpen& open) {
  if (open.ack_levels().empty()) {
    levels_[kDurable].wanted = true;
    levels_[kIntegrated].wanted = true;
  }
  for (int i = 0; i < open.ack_levels_size(); ++i) {
    const auto level = std::find(kWireLevels.begin(), kWireLevels.end(), open.ack_levels(i));
    if (level == kWireLevels.end()) {
      return InvalidField(reason::kBadValue,
                          absl::StrCat("ack_levels[", i, "]"),
                          absl::StrCat("the acknowledgement level must be a known value, got ",
                                       static_cast<int>(open.ack_levels(i))));
    }
    levels_[static_cast<std::size_t>(level - kWireLevels.begin())].wanted = true;
  }
  return absl::OkStatus();
}

v1::UploadCredit UploadResponses::initial_credit() const {
  v1::UploadCredit credit;
  credit.set_frames(window_.frames);
  credit.set_bytes(window_.bytes);
  return credit;
}

absl::Status UploadResponses::Spend(std::uint64_t frames, std::uint64_t bytes) {
  if (frames > available_.frames || bytes > available_.bytes) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     reason::kQueueFull,
                     absl::StrCat("the batch needs credit for ",
                                  frames,
                                  " frames and ",
                                  bytes,
                                  " bytes, but the client has ",
                                  available_.frames,
                                  " frames and ",
                                  available_.bytes,
                                  " bytes"));
  }
  available_.frames -= frames;
  available_.bytes -= bytes;
  return absl::OkStatus();
}

void UploadResponses::NoteReceived(ClientSequence through, std::vector<RefusedFrame> refused) {
  std::move(refused.begin(), refused.end(), std::back_inserter(refused_));
  BatchProgress progress;
  progress.through = through;
  Note(kReceived, progress);
}

void UploadResponses::NoteDurable(const BatchProgress& progress) { Note(kDurable, progress); }

void UploadResponses::NoteIntegrated(const BatchProgress& progress) {
  Note(kDurable, progress);
  Note(kIntegrated, progress);
  returned_.frames += progress.frames;
  returned_.bytes += progress.bytes;
}

bool UploadResponses::HasNext() const {
  const auto is_due = [](const Level& level) { return level.due; };
  return std::any_of(levels_.begin(), levels_.end(), is_due) || returned_.frames > 0;
}

v1::UploadFramesResponse UploadResponses::TakeNext() {
  for (std::size_t level = 0; level < kLevels; ++level) {
    if (levels_[level].due) return TakeAck(level);
  }
  return TakeCredit();
}

void UploadResponses::Note(std::size_t level, const BatchProgress& progress) {
  Level& entry = levels_[level];
  // A report about an earlier part may arrive late. It contains nothing new. The end of a session
  // has no frame of its own, but a log position.
  const bool is_new =
      progress.through > entry.progress.through ||
      (progress.through == entry.progress.through && progress.map_seq > entry.progress.map_seq);
  if (!entry.wanted || !is_new) return;
  entry.progress = progress;
  entry.due = true;
}

v1::UploadFramesResponse UploadResponses::TakeAck(std::size_t level) {
  Level& entry = levels_[level];
  entry.due = false;
  v1::UploadFramesResponse response;
  v1::UploadAck* ack = response.mutable_ack();
  ack->set_level(kWireLevels[level]);
  ack->set_client_seq(entry.progress.through.value());
  if (level != kReceived) ack->set_map_seq(entry.progress.map_seq.value());
  if (level == kIntegrated) ack->set_revision(entry.progress.revision.value());
  // `entry` is the lowest requested level: it is the first to reach these frames.
  while (!refused_.empty() && refused_.front().sequence <= entry.progress.through) {
    *ack->add_refused() = ToProto(refused_.front());
    refused_.pop_front();
  }
  return response;
}

v1::UploadFramesResponse UploadResponses::TakeCredit() {
  v1::UploadFramesResponse response;
  response.mutable_credit()->set_frames(returned_.frames);
  response.mutable_credit()->set_bytes(returned_.bytes);
  available_.frames += returned_.frames;
  available_.bytes += returned_.bytes;
  returned_ = {};
  return response;
}

}  // namespace steadymap

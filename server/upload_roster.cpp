#include "server/upload_roster.h"

#include <vector>

#include <absl/strings/str_cat.h>

#include "core/error.h"

namespace steadymap {
namespace {

// Each holds a message of at most `max_message_bytes`; robots use streams.
constexpr std::size_t kMaxCalls = 64;

}  // namespace

absl::Status DrainingError() {
  return MakeError(absl::StatusCode::kUnavailable,
                   reason::kDraining,
                   "the server is about to stop; go on with the next one");
}

absl::Status UploadRoster::Enter(MapKey map,
                                 const std::string& robot,
                                 std::shared_ptr<ActiveUpload> upload) {
  std::shared_ptr<ActiveUpload> before;
  {
    const absl::MutexLock lock(&mutex_);
    if (draining_) return DrainingError();
    std::shared_ptr<ActiveUpload>& entry = streams_[Key(map, robot)];
    before = std::exchange(entry, std::move(upload));
    if (before != nullptr) ++superseded_;
  }
  if (before != nullptr) {
    before->End(
        MakeError(absl::StatusCode::kAborted,
                  reason::kUploadSuperseded,
                  absl::StrCat("robot ", robot, " has opened another upload to the same map")));
  }
  return absl::OkStatus();
}

void UploadRoster::Leave(MapKey map, const std::string& robot, const ActiveUpload* upload) {
  std::shared_ptr<ActiveUpload> left;
  const absl::MutexLock lock(&mutex_);
  const auto entry = streams_.find(Key(map, robot));
  if (entry != streams_.end() && entry->second.get() == upload) {
    left = std::move(entry->second);
    streams_.erase(entry);
  } else {
    --superseded_;
  }
}

absl::Status UploadRoster::EnterCall() {
  const absl::MutexLock lock(&mutex_);
  if (draining_) return DrainingError();
  if (calls_ >= kMaxCalls) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     reason::kQueueFull,
                     absl::StrCat(kMaxCalls, " calls upload already; use UploadFrames"));
  }
  ++calls_;
  return absl::OkStatus();
}

void UploadRoster::LeaveCall() {
  const absl::MutexLock lock(&mutex_);
  --calls_;
}

void UploadRoster::EndMap(MapKey map, const absl::Status& status) {
  std::vector<std::shared_ptr<ActiveUpload>> ended;
  {
    const absl::MutexLock lock(&mutex_);
    for (auto entry = streams_.lower_bound(Key(map, std::string()));
         entry != streams_.end() && entry->first.first == map;
         ++entry) {
      ended.push_back(entry->second);
    }
  }
  for (const std::shared_ptr<ActiveUpload>& upload : ended) upload->End(status);
}

void UploadRoster::Drain() {
  std::vector<std::shared_ptr<ActiveUpload>> drained;
  {
    const absl::MutexLock lock(&mutex_);
    draining_ = true;
    for (const auto& [key, upload] : streams_) drained.push_back(upload);
  }
  for (const std::shared_ptr<ActiveUpload>& upload : drained) upload->Drain(DrainingError());
}

bool UploadRoster::AwaitEmpty(absl::Time deadline) {
  const absl::MutexLock lock(&mutex_);
  return mutex_.AwaitWithDeadline(absl::Condition(this, &UploadRoster::IsEmpty), deadline);
}

std::size_t UploadRoster::stream_count() const {
  const absl::MutexLock lock(&mutex_);
  return streams_.size();
}

}  // namespace steadymap

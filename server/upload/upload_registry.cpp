#include "server/upload/upload_registry.h"

#include <algorithm>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

// Each call holds a message of at most `max_message_bytes`. Robots use streams.
constexpr std::size_t kMaxCalls = 64;

// See `LimitOptions::max_upload_streams`.
constexpr std::size_t kQueueBytesPerStream = std::size_t{512} << 10;
constexpr std::size_t kLeastMaxStreams = 16;

// A long retry delay, because streams rarely end.
constexpr std::int64_t kStreamRetryDelayMs = 5000;

}  // namespace

std::size_t MaxUploadStreams(const LimitOptions& limits) {
  if (limits.max_upload_streams > 0) return limits.max_upload_streams;
  return std::max(kLeastMaxStreams, limits.queue_bytes_total / kQueueBytesPerStream);
}

absl::Status DrainingError() {
  return MakeError(absl::StatusCode::kUnavailable,
                   reason::kDraining,
                   "the server is shutting down; reconnect after its restart");
}

absl::Status UploadRegistry::Enter(MapKey map,
                                   const SessionName& session,
                                   std::shared_ptr<ActiveUpload> upload) {
  std::shared_ptr<ActiveUpload> before;
  {
    const absl::MutexLock lock(&mutex_);
    if (draining_) return DrainingError();
    const Key key(map, session.sensor);
    if (!streams_.contains(key) && streams_.size() >= max_streams_) {
      return WithRetryDelay(MakeError(absl::StatusCode::kResourceExhausted,
                                      reason::kQueueFull,
                                      absl::StrCat("the server has ",
                                                   streams_.size(),
                                                   " upload streams, which is the maximum")),
                            kStreamRetryDelayMs);
    }
    Stream& entry = streams_[key];
    entry.session = session;
    before = std::exchange(entry.upload, std::move(upload));
    if (before != nullptr) ++superseded_;
  }
  if (before != nullptr) {
    before->End(MakeError(
        absl::StatusCode::kAborted,
        reason::kUploadSuperseded,
        absl::StrCat(
            "sensor ", session.sensor.ToString(), " has opened another upload to the same map")));
  }
  return absl::OkStatus();
}

void UploadRegistry::Leave(MapKey map, const SessionName& session, const ActiveUpload* upload) {
  std::shared_ptr<ActiveUpload> left;
  const absl::MutexLock lock(&mutex_);
  const auto entry = streams_.find(Key(map, session.sensor));
  if (entry != streams_.end() && entry->second.upload.get() == upload) {
    left = std::move(entry->second.upload);
    streams_.erase(entry);
  } else {
    --superseded_;
  }
}

absl::Status UploadRegistry::EnterCall() {
  const absl::MutexLock lock(&mutex_);
  if (draining_) return DrainingError();
  if (calls_ >= kMaxCalls) {
    return MakeError(
        absl::StatusCode::kResourceExhausted,
        reason::kQueueFull,
        absl::StrCat(
            kMaxCalls,
            " UploadFrameBatch calls are in progress, which is the maximum; use UploadFrames"));
  }
  ++calls_;
  return absl::OkStatus();
}

void UploadRegistry::LeaveCall() {
  const absl::MutexLock lock(&mutex_);
  --calls_;
}

std::set<SessionName> UploadRegistry::SessionsOf(MapKey map) const {
  std::set<SessionName> sessions;
  const absl::MutexLock lock(&mutex_);
  for (auto entry = streams_.lower_bound(Key(map, SensorName()));
       entry != streams_.end() && entry->first.first == map;
       ++entry) {
    sessions.insert(entry->second.session);
  }
  return sessions;
}

void UploadRegistry::EndMap(MapKey map, const absl::Status& status) {
  std::vector<std::shared_ptr<ActiveUpload>> ended;
  {
    const absl::MutexLock lock(&mutex_);
    for (auto entry = streams_.lower_bound(Key(map, SensorName()));
         entry != streams_.end() && entry->first.first == map;
         ++entry) {
      ended.push_back(entry->second.upload);
    }
  }
  for (const std::shared_ptr<ActiveUpload>& upload : ended) upload->End(status);
}

void UploadRegistry::Drain() {
  std::vector<std::shared_ptr<ActiveUpload>> drained;
  {
    const absl::MutexLock lock(&mutex_);
    draining_ = true;
    for (const auto& [key, stream] : streams_) drained.push_back(stream.upload);
  }
  for (const std::shared_ptr<ActiveUpload>& upload : drained) upload->Drain(DrainingError());
}

bool UploadRegistry::AwaitEmpty(absl::Time deadline) {
  const absl::MutexLock lock(&mutex_);
  return mutex_.AwaitWithDeadline(absl::Condition(this, &UploadRegistry::IsEmpty), deadline);
}

void UploadRegistry::SetMaxStreams(std::size_t max_streams) {
  const absl::MutexLock lock(&mutex_);
  max_streams_ = max_streams;
}

std::size_t UploadRegistry::stream_count() const {
  const absl::MutexLock lock(&mutex_);
  return streams_.size();
}

}  // namespace steadymap

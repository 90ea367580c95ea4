#include "server/rpc/stream_limiter.h"

#include <string_view>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

absl::Status TooManyStreams(std::size_t count, const std::string& scope) {
  return MakeError(
      absl::StatusCode::kResourceExhausted,
      reason::kQueueFull,
      absl::StrCat(count, " exports and sections ", scope, " are open, which is the maximum"));
}

}  // namespace

absl::Status StreamLimiter::Enter(const std::shared_ptr<LimitedStream>& stream,
                                  const std::string& peer) {
  const std::string address = AddressOfPeer(peer);
  const absl::MutexLock lock(&mutex_);
  if (count_ >= limits_.max_streams) return TooManyStreams(count_, "of all clients");
  const auto known = count_by_address_.find(address);
  if (known != count_by_address_.end() && known->second >= limits_.max_per_address) {
    return TooManyStreams(known->second, "of this client's address");
  }
  ++count_by_address_[address];
  ++count_;
  streams_.emplace(stream, Entry{address});
  return absl::OkStatus();
}

void StreamLimiter::Discount(const std::shared_ptr<LimitedStream>& stream) {
  const absl::MutexLock lock(&mutex_);
  const auto entry = streams_.find(stream);
  if (entry != streams_.end()) RemoveFromCount(&entry->second);
}

void StreamLimiter::Leave(const std::shared_ptr<LimitedStream>& stream) {
  const absl::MutexLock lock(&mutex_);
  const auto entry = streams_.find(stream);
  if (entry == streams_.end()) return;
  RemoveFromCount(&entry->second);
  streams_.erase(entry);
}

void StreamLimiter::RemoveFromCount(Entry* entry) {
  if (!std::exchange(entry->counts, false)) return;
  const auto of_address = count_by_address_.find(entry->address);
  if (--of_address->second == 0) count_by_address_.erase(of_address);
  --count_;
}

void StreamLimiter::EndStalled(LimitedStream::Clock::time_point now) {
  std::vector<std::shared_ptr<LimitedStream>> streams;
  {
    const absl::MutexLock lock(&mutex_);
    for (const auto& [stream, entry] : streams_) streams.push_back(stream);
  }
  for (const std::shared_ptr<LimitedStream>& stream : streams) {
    stream->EndIfStalled(now, limits_.stall_timeout);
  }
}

std::size_t StreamLimiter::stream_count() const {
  const absl::MutexLock lock(&mutex_);
  return count_;
}

std::string AddressOfPeer(const std::string& peer) {
  const bool has_port = peer.starts_with("ipv4:") || peer.starts_with("ipv6:");
  return has_port ? peer.substr(0, peer.rfind(':')) : peer;
}

}  // namespace steadymap

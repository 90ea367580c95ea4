#include "server/rpc/peer_limiter.h"

#include <algorithm>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

// Bounds the buckets to a few hundred kilobytes.
constexpr std::size_t kMaxBuckets = 4096;

/// Returns the peer without its port.
std::string_view AddressOf(std::string_view peer) {
  const bool has_port = peer.starts_with("ipv4:") || peer.starts_with("ipv6:");
  return has_port ? peer.substr(0, peer.rfind(':')) : peer;
}

}  // namespace

absl::Status PeerLimiter::Take(std::string_view peer, absl::Time now) {
  const std::string_view address = AddressOf(peer);
  const absl::MutexLock lock(&mutex_);
  Bucket& bucket = FindBucket(address, now);
  Fill(&bucket, now);
  if (bucket.tokens < 1.0) {
    return MakeError(
        absl::StatusCode::kResourceExhausted,
        reason::kRateLimit,
        absl::StrCat(
            "more than ", options_.per_second, " calls of this kind per second from one address"));
  }
  bucket.tokens -= 1.0;
  return absl::OkStatus();
}

void PeerLimiter::Fill(Bucket* bucket, absl::Time now) const {
  // If the clock was set back, the bucket gets no tokens for that interval.
  const double seconds = std::max(0.0, absl::ToDoubleSeconds(now - bucket->filled));
  bucket->tokens = std::min(options_.burst, bucket->tokens + seconds * options_.per_second);
  bucket->filled = now;
}

PeerLimiter::Bucket& PeerLimiter::FindBucket(std::string_view address, absl::Time now) {
  const auto found = buckets_.find(address);
  if (found != buckets_.end()) return found->second;
  if (buckets_.size() >= kMaxBuckets) {
    // A full bucket is equivalent to a missing one.
    std::erase_if(buckets_, [this, now](const auto& entry) {
      Bucket bucket = entry.second;
      Fill(&bucket, now);
      return bucket.tokens >= options_.burst;
    });
  }
  const std::string key = buckets_.size() < kMaxBuckets ? std::string(address) : std::string();
  return buckets_.try_emplace(key, Bucket{options_.burst, now}).first->second;
}

}  // namespace steadymap

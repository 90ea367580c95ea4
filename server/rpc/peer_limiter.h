#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

namespace steadymap {

/// A rate limit per IP address: one token bucket each, filled at a constant rate. All processes
/// behind one address share its bucket. Memory is bounded: if very many addresses are active, the
/// newest ones share one bucket. Thread-safe.
class PeerLimiter {
 public:
  struct Options {
    double per_second = 1.0;  ///< Rate at which a bucket is filled, > 0.
    double burst = 1.0;       ///< Capacity of a bucket, >= 1.
  };

  explicit PeerLimiter(const Options& options) : options_(options) {}

  /// Takes a token of `peer`, a gRPC peer string such as `ipv4:10.0.0.7:51234`; the port is
  /// ignored. Errors: `ResourceExhausted` with reason `RATE_LIMIT` if the bucket is empty.
  absl::Status Take(std::string_view peer, absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Bucket {
    double tokens = 0.0;  ///< Tokens at the time `filled`.
    absl::Time filled;
  };

  void Fill(Bucket* bucket, absl::Time now) const;
  Bucket& FindBucket(std::string_view address, absl::Time now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Options options_;
  absl::Mutex mutex_;
  std::map<std::string, Bucket, std::less<>> buckets_ ABSL_GUARDED_BY(mutex_);  ///< By address.
};

}  // namespace steadymap

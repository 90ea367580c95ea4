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

/// How often each address may do something: a bucket of tokens for each, filled at a steady rate.
/// All processes behind one address share its bucket. Bounded: of very many addresses at a time,
/// those that come last share one. Thread-safe.
class PeerLimiter {
 public:
  struct Options {
    double per_second = 1.0;  ///< Tokens that a bucket gets, > 0.
    double burst = 1.0;       ///< Tokens that it holds, >= 1.
  };

  explicit PeerLimiter(const Options& options) : options_(options) {}

  /// Takes a token of the peer that gRPC calls `peer`, such as `ipv4:10.0.0.7:51234`; its port does
  /// not count. Errors: `ResourceExhausted` with reason `RATE_LIMIT` if the
  /// bucket is empty.
  absl::Status Take(std::string_view peer, absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Bucket {
    double tokens = 0.0;  ///< At `filled`.
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

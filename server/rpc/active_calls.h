#pragma once

#include <memory>
#include <set>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>
#include <grpcpp/support/server_interceptor.h>

namespace steadymap {

/// The active calls of the server's services. Records for each call whether a message to the client
/// is pending, so that a shutdown can wait for the server's own work but not for clients that have
/// stopped reading. Thread-safe.
class ActiveCalls {
 public:
  /// One call. Its interceptor records its state.
  class Call {
   public:
    explicit Call(ActiveCalls* calls) : calls_(calls) { calls_->Enter(this); }

    ~Call() { calls_->Leave(this); }

    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    /// Records that a message to the client is pending from now on.
    void BeginSending() { calls_->NoteSending(this, absl::Now()); }

    /// Records that gRPC has written the message.
    void EndSending() { calls_->NoteSending(this, absl::InfiniteFuture()); }

   private:
    friend class ActiveCalls;

    ActiveCalls* const calls_;
    absl::Time sending_since_ = absl::InfiniteFuture();  ///< Guarded by `ActiveCalls::mutex_`.
  };

  ActiveCalls() = default;
  ActiveCalls(const ActiveCalls&) = delete;
  ActiveCalls& operator=(const ActiveCalls&) = delete;

  /// Makes an interceptor factory for a server builder. The interceptors count calls of the
  /// steadymap services; this object must outlive them. Calls of the health service, reflection and
  /// channelz are not counted, because a client's watch of the health service never ends.
  std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeInterceptorFactory();

  /// Waits until `deadline` or until all remaining calls have had a pending message for at least
  /// `patience`. Returns true if no call remains.
  bool AwaitEnd(absl::Time deadline, absl::Duration patience) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Enter(const Call* call) ABSL_LOCKS_EXCLUDED(mutex_);
  void Leave(const Call* call) ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteSending(Call* call, absl::Time since) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the time at which all current calls will have had a pending message for `patience`;
  /// the infinite future if a call has none, because the server is working on it.
  absl::Time PatienceEnds(absl::Duration patience) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  absl::Mutex mutex_;
  std::set<const Call*> calls_ ABSL_GUARDED_BY(mutex_);
  bool changed_ ABSL_GUARDED_BY(mutex_) = false;  ///< A call changed since the last check.
};

}  // namespace steadymap

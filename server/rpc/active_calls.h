#pragma once

#include <memory>
#include <set>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>
#include <grpcpp/support/server_interceptor.h>

namespace steadymap {

/// The calls of a server's services that have not ended, and which of them wait for their client:
/// what lets a server that stops wait for its own work, and not for clients that take nothing.
/// Thread-safe.
class ActiveCalls {
 public:
  /// One call; what it does is noted by the interceptor that belongs to it.
  class Call {
   public:
    explicit Call(ActiveCalls* calls) : calls_(calls) { calls_->Enter(this); }

    ~Call() { calls_->Leave(this); }

    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    /// Something is on its way to the client from now on.
    void BeginSending() { calls_->NoteSending(this, absl::Now()); }

    /// The client has taken it.
    void EndSending() { calls_->NoteSending(this, absl::InfiniteFuture()); }

   private:
    friend class ActiveCalls;

    ActiveCalls* const calls_;
    absl::Time sending_since_ = absl::InfiniteFuture();  ///< Guarded by `ActiveCalls::mutex_`.
  };

  ActiveCalls() = default;
  ActiveCalls(const ActiveCalls&) = delete;
  ActiveCalls& operator=(const ActiveCalls&) = delete;

  /// For a server builder: counts the calls of our services, as long as this lives. Calls of health
  /// service, reflection and channelz are left out: those who watch a server's health never end.
  std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeInterceptorFactory();

  /// Waits until no call is left but those whose clients have taken nothing for `patience`, or
  /// until `deadline`. Returns whether none is left at all.
  bool AwaitEnd(absl::Time deadline, absl::Duration patience) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Enter(const Call* call) ABSL_LOCKS_EXCLUDED(mutex_);
  void Leave(const Call* call) ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteSending(Call* call, absl::Time since) ABSL_LOCKS_EXCLUDED(mutex_);

  /// When the last of the calls has kept its server waiting for `patience`, as things stand; never
  /// while the server is at work for one.
  absl::Time PatienceEnds(absl::Duration patience) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  absl::Mutex mutex_;
  std::set<const Call*> calls_ ABSL_GUARDED_BY(mutex_);
  bool changed_ ABSL_GUARDED_BY(mutex_) = false;  ///< Since `AwaitEnd` looked last.
};

}  // namespace steadymap

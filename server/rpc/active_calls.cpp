#include "server/rpc/active_calls.h"

#include <algorithm>
#include <string_view>

#include <absl/time/clock.h>
#include <grpcpp/support/interceptor.h>

namespace steadymap {
namespace {

using grpc::experimental::InterceptionHookPoints;

constexpr std::string_view kOurServices = "/steadymap.";

/// Owned by gRPC; destroyed at the end of its call.
class CountingInterceptor final : public grpc::experimental::Interceptor {
 public:
  explicit CountingInterceptor(ActiveCalls* calls) : call_(calls) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_MESSAGE) ||
        batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      call_.BeginSending();
    } else if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::POST_SEND_MESSAGE)) {
      call_.EndSending();
    }
    batch->Proceed();
  }

 private:
  ActiveCalls::Call call_;
};

class CountingInterceptorFactory final
    : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit CountingInterceptorFactory(ActiveCalls* calls) : calls_(calls) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    if (!std::string_view(info->method()).starts_with(kOurServices)) return nullptr;
    return new CountingInterceptor(calls_);
  }

 private:
  ActiveCalls* const calls_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>
ActiveCalls::MakeInterceptorFactory() {
  return std::make_unique<CountingInterceptorFactory>(this);
}

bool ActiveCalls::AwaitEnd(absl::Time deadline, absl::Duration patience) {
  const absl::MutexLock lock(&mutex_);
  while (!calls_.empty()) {
    const absl::Time until = std::min(deadline, PatienceEnds(patience));
    if (until <= absl::Now()) return false;
    changed_ = false;
    mutex_.AwaitWithDeadline(absl::Condition(&changed_), until);
  }
  return true;
}

void ActiveCalls::Enter(const Call* call) {
  const absl::MutexLock lock(&mutex_);
  calls_.insert(call);
  changed_ = true;
}

void ActiveCalls::Leave(const Call* call) {
  const absl::MutexLock lock(&mutex_);
  calls_.erase(call);
  changed_ = true;
}

void ActiveCalls::NoteSending(Call* call, absl::Time since) {
  const absl::MutexLock lock(&mutex_);
  call->sending_since_ = since;
  changed_ = true;
}

absl::Time ActiveCalls::PatienceEnds(absl::Duration patience) const {
  absl::Time last = absl::InfinitePast();
  for (const Call* call : calls_) last = std::max(last, call->sending_since_);
  return last + patience;
}

}  // namespace steadymap

#include "server/rpc/calls_under_way.h"

#include <algorithm>
#include <string_view>

#include <absl/time/clock.h>
#include <grpcpp/support/interceptor.h>

namespace steadymap {
namespace {

using grpc::experimental::InterceptionHookPoints;

constexpr std::string_view kOurServices = "/steadymap.";

/// Lives as long as its call.
class CountingInterceptor final : public grpc::experimental::Interceptor {
 public:
  explicit CountingInterceptor(CallsUnderWay* calls) : call_(calls) {}

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
  CallsUnderWay::Call call_;
};

class CountingInterceptorFactory final
    : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit CountingInterceptorFactory(CallsUnderWay* calls) : calls_(calls) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    if (!std::string_view(info->method()).starts_with(kOurServices)) return nullptr;
    return new CountingInterceptor(calls_);
  }

 private:
  CallsUnderWay* const calls_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>
CallsUnderWay::MakeInterceptorFactory() {
  return std::make_unique<CountingInterceptorFactory>(this);
}

bool CallsUnderWay::AwaitEnd(absl::Time deadline, absl::Duration patience) {
  const absl::MutexLock lock(&mutex_);
  while (!calls_.empty()) {
    const absl::Time until = std::min(deadline, PatienceEnds(patience));
    if (until <= absl::Now()) return false;
    changed_ = false;
    mutex_.AwaitWithDeadline(absl::Condition(&changed_), until);
  }
  return true;
}

void CallsUnderWay::Enter(const Call* call) {
  const absl::MutexLock lock(&mutex_);
  calls_.insert(call);
  changed_ = true;
}

void CallsUnderWay::Leave(const Call* call) {
  const absl::MutexLock lock(&mutex_);
  calls_.erase(call);
  changed_ = true;
}

void CallsUnderWay::NoteSending(Call* call, absl::Time since) {
  const absl::MutexLock lock(&mutex_);
  call->sending_since_ = since;
  changed_ = true;
}

absl::Time CallsUnderWay::PatienceEnds(absl::Duration patience) const {
  absl::Time last = absl::InfinitePast();
  for (const Call* call : calls_) last = std::max(last, call->sending_since_);
  return last + patience;
}

}  // namespace steadymap

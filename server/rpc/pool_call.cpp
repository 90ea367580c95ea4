#include "server/rpc/pool_call.h"

#include <exception>
#include <memory>
#include <utility>

#include <spdlog/spdlog.h>

#include "core/types/error.h"
#include "proto/grpc_status.h"

namespace steadymap {
namespace {

/// The reactor of a unary call, owned by gRPC.
class UnaryReactor final : public grpc::ServerUnaryReactor {
 public:
  const Cancellation& cancellation() const { return cancellation_; }

  void OnCancel() override { cancellation_.Cancel(); }

  void OnDone() override { delete this; }

 private:
  const Cancellation cancellation_;
};

void RunOrRefuse(WorkerPool* pool, UnaryReactor* reactor, CallWork work) {
  const bool submitted = pool->TrySubmit([reactor, work = std::move(work)] {
    const Cancellation& cancellation = reactor->cancellation();
    absl::Status status = cancellation.Check();
    if (status.ok()) status = RunGuarded([&] { return work(cancellation); });
    reactor->Finish(ToGrpcStatus(status));
  });
  if (!submitted) reactor->Finish(ToGrpcStatus(PoolFullError()));
}

}  // namespace

grpc::ServerUnaryReactor* AnswerOnPool(WorkerPool* pool, CallWork work) {
  auto* reactor = new UnaryReactor();
  RunOrRefuse(pool, reactor, std::move(work));
  return reactor;
}

grpc::ServerUnaryReactor* AnswerOnPoolAfter(const std::function<void(std::function<void()>)>& wait,
                                            WorkerPool* pool,
                                            CallWork work) {
  auto* reactor = new UnaryReactor();
  wait([pool, reactor, work = std::move(work)] { RunOrRefuse(pool, reactor, work); });
  return reactor;
}

grpc::ServerUnaryReactor* AnswerLaterOnPool(WorkerPool* pool,
                                            std::function<void(FinishCall)> work) {
  auto* reactor = new UnaryReactor();
  const FinishCall finish = [reactor](const absl::Status& status) {
    reactor->Finish(ToGrpcStatus(status));
  };
  const bool submitted = pool->TrySubmit([work = std::move(work), finish] {
    const absl::Status status = RunGuarded([&] {
      work(finish);
      return absl::OkStatus();
    });
    if (!status.ok()) finish(status);
  });
  if (!submitted) finish(PoolFullError());
  return reactor;
}

grpc::ServerUnaryReactor* RefuseCall(const absl::Status& status) {
  auto* reactor = new UnaryReactor();
  reactor->Finish(ToGrpcStatus(status));
  return reactor;
}

absl::Status RunGuarded(const std::function<absl::Status()>& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    spdlog::error("a call failed with an exception: {}", error.what());
    return MakeError(absl::StatusCode::kInternal, reason::kInternal, error.what());
  }
}

absl::Status PoolFullError() {
  return WithRetryDelay(MakeError(absl::StatusCode::kResourceExhausted,
                                  reason::kQueueFull,
                                  "too many calls of this kind are waiting"),
                        1000);
}

}  // namespace steadymap

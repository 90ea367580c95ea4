#include "server/pool_call.h"

#include <exception>
#include <utility>

#include <grpcpp/server_context.h>
#include <spdlog/spdlog.h>

#include "core/error.h"
#include "proto/grpc_status.h"

namespace steadymap {

grpc::ServerUnaryReactor* AnswerOnPool(WorkerPool* pool,
                                       grpc::CallbackServerContext* context,
                                       std::function<absl::Status()> work) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const bool submitted = pool->TrySubmit(
      [reactor, work = std::move(work)] { reactor->Finish(ToGrpcStatus(RunGuarded(work))); });
  if (!submitted) reactor->Finish(ToGrpcStatus(PoolFullError()));
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
  return MakeError(absl::StatusCode::kResourceExhausted,
                   reason::kQueueFull,
                   "too many calls of this kind wait already");
}

}  // namespace steadymap

#pragma once

#include <functional>

#include <absl/status/status.h>
#include <grpcpp/support/server_callback.h>

#include "server/worker_pool.h"

namespace steadymap {

/// Runs `work`, then finishes a call with its status; an exception becomes `Internal`. If the pool
/// is full the call ends with `ResourceExhausted`, reason `QUEUE_FULL`. Returns at once.
grpc::ServerUnaryReactor* AnswerOnPool(WorkerPool* pool,
                                       grpc::CallbackServerContext* context,
                                       std::function<absl::Status()> work);

/// What `work` returns; `Internal` for an exception that leaves it. The outermost frame of a
/// handler.
absl::Status RunGuarded(const std::function<absl::Status()>& work);

/// The error for a call that finds its pool full.
absl::Status PoolFullError();

}  // namespace steadymap

#pragma once

#include <functional>

#include <absl/status/status.h>
#include <grpcpp/support/server_callback.h>

#include "core/types/cancellation.h"
#include "server/process/worker_pool.h"

namespace steadymap {

/// Work of a call that ends with its status.
using CallWork = std::function<absl::Status(const Cancellation&)>;

/// Finishes a call, once, from any thread.
using FinishCall = std::function<void(absl::Status)>;

/// Runs `work`, then finishes a call with its status; an exception becomes `Internal`. If the pool
/// is full the call ends with `ResourceExhausted`, reason `QUEUE_FULL`. A call that is cancelled
/// before its turn does no work. Returns at once.
grpc::ServerUnaryReactor* AnswerOnPool(WorkerPool* pool, CallWork work);

/// The same for a call that first waits for something without a thread: `wait` is called at once
/// and calls what it is given when the work may begin, or never if the server ends before.
grpc::ServerUnaryReactor* AnswerOnPoolAfter(const std::function<void(std::function<void()>)>& wait,
                                            WorkerPool* pool,
                                            CallWork work);

/// The same for work that ends later: `work` gets the function that finishes the call.
grpc::ServerUnaryReactor* AnswerLaterOnPool(WorkerPool* pool, std::function<void(FinishCall)> work);

/// Ends a call with an error before anything was done for it.
grpc::ServerUnaryReactor* RefuseCall(const absl::Status& status);

/// What `work` returns; `Internal` for an exception that leaves it. The outermost frame of a
/// handler.
absl::Status RunGuarded(const std::function<absl::Status()>& work);

/// The error for a call that finds its pool full.
absl::Status PoolFullError();

}  // namespace steadymap

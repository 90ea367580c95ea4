#pragma once

#include <functional>

#include <absl/status/status.h>
#include <grpcpp/support/server_callback.h>

#include "core/types/cancellation.h"
#include "server/process/worker_pool.h"

namespace steadymap {

/// The work of a call; returns the status of the call.
using CallWork = std::function<absl::Status(const Cancellation&)>;

/// Finishes a call. Must be called once; from any thread.
using FinishCall = std::function<void(absl::Status)>;

/// Runs `work` on the pool, then finishes the call with its status; an exception becomes
/// `Internal`. If the pool is full, the call ends with `ResourceExhausted`, reason `QUEUE_FULL`. A
/// call that is cancelled while it waits for a thread does no work. Does not block.
grpc::ServerUnaryReactor* AnswerOnPool(WorkerPool* pool, CallWork work);

/// Runs `work` like `AnswerOnPool`, but first waits without a thread: `wait` is called immediately
/// and must call its argument when the work may begin. It never calls it if the server stops
/// before.
grpc::ServerUnaryReactor* AnswerOnPoolAfter(const std::function<void(std::function<void()>)>& wait,
                                            WorkerPool* pool,
                                            CallWork work);

/// Runs `work` on the pool like `AnswerOnPool`, for calls that end after `work` has returned:
/// `work` receives the function that finishes the call.
grpc::ServerUnaryReactor* AnswerLaterOnPool(WorkerPool* pool, std::function<void(FinishCall)> work);

/// Ends a call with an error before any work is done.
grpc::ServerUnaryReactor* RefuseCall(const absl::Status& status);

/// Returns the result of `work`; `Internal` if an exception leaves it. The outermost frame of a
/// handler.
absl::Status RunGuarded(const std::function<absl::Status()>& work);

/// Returns the error of a call that finds its pool full.
absl::Status PoolFullError();

}  // namespace steadymap

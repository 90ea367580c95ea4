#pragma once

#include <functional>
#include <memory>
#include <vector>

#include <absl/status/status.h>

#include "server/mapping/map_runtime.h"
#include "server/mapping/pending_batch.h"
#include "server/process/worker_pool.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// Source and destination of an upload's frames.
struct UploadRoute {
  std::shared_ptr<MapRuntime> map;
  std::shared_ptr<const MapConfig> config;  ///< Configuration of the map at its creation.
  SessionName session;
  bool in_order = false;       ///< See `PendingBatch::in_order`.
  ClientSequence predecessor;  ///< `PendingBatch::predecessor` of the first part.
  std::shared_ptr<UploadObserver> observer;
};

/// Maximum number of frames in a batch.
inline constexpr int kMaxBatchFrames = 256;

/// Returns OK if the numbering of a batch is valid: 1 to `kMaxBatchFrames` frames, and client
/// sequences that start at 1 or above and do not overflow. Errors: `InvalidArgument` with the field
/// relative to the batch. Cost: constant.
absl::Status CheckNumbering(const v1::FrameBatch& batch);

/// Returns the client sequence of the last frame of a batch that passed `CheckNumbering`.
ClientSequence LastSequenceOf(const v1::FrameBatch& batch);

/// A received batch whose frames are not decoded yet.
struct ReadBatch {
  v1::FrameBatch frames;
  FrameBudget::Reservation memory;  ///< Memory of the message.
};

/// Processes one batch on a thread pool: checks its checksum, skips frames that are durable
/// already, decodes and validates the others one by one within the map's memory budget, and adds
/// them to the map's queue. While the budget is exhausted, no thread waits; the processing
/// continues when memory is free.
class BatchIntake : public std::enable_shared_from_this<BatchIntake> {
 public:
  /// Receives OK if every frame was queued or refused; otherwise the reason for which the upload
  /// must end: `DataLoss` with reason `CHECKSUM` (no frame of the batch was accepted),
  /// `QUEUE_FULL`, or an error of `MapRuntime::CheckUploads`.
  using Done = std::function<void(const absl::Status&)>;

  /// Starts the processing. Calls `done` once, from a thread of the pool or from the thread that
  /// releases memory. `batch` must have passed `CheckNumbering`. `pool` must outlive the
  /// processing.
  static void Start(WorkerPool* pool, UploadRoute route, ReadBatch batch, Done done);

  /// Used only by `Start`.
  BatchIntake(WorkerPool* pool, UploadRoute route, ReadBatch batch, Done done);

  /// Calls `done` if it was not called before: a map that closes drops the requests that wait for
  /// its memory budget.
  ~BatchIntake();

  BatchIntake(const BatchIntake&) = delete;
  BatchIntake& operator=(const BatchIntake&) = delete;

 private:
  void Submit();
  void Run();
  absl::Status CheckBatch() const;
  bool TakeFrame(const v1::Frame& message, ClientSequence sequence);
  void Decode(const v1::Frame& message, ClientSequence sequence);
  absl::Status HandOver(bool last_piece);
  void Finish(const absl::Status& status);
  ClientSequence SequenceAt(int index) const;

  WorkerPool* const pool_;
  const UploadRoute route_;
  const FrameBudget::Reservation memory_;  ///< Memory of the message.
  v1::FrameBatch batch_;
  const std::uint64_t batch_bytes_;
  Done done_;

  int next_ = 0;                          ///< Index of the next frame.
  int handed_over_ = 0;                   ///< Number of frames already in the queue.
  ClientSequence predecessor_;            ///< Predecessor of the next part.
  FrameBudget::Reservation reservation_;  ///< Memory of the next frame, after a wait.
  std::vector<PendingFrame> frames_;
  std::vector<RefusedFrame> refused_;
};

}  // namespace steadymap

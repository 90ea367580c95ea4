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

/// Where the frames of an upload come from and go to.
struct UploadRoute {
  std::shared_ptr<MapRuntime> map;
  std::shared_ptr<const MapConfig> config;  ///< Of the map, as it was created.
  SessionName session;
  bool in_order = false;       ///< As in PendingBatch.
  ClientSequence predecessor;  ///< Of the batch's first piece, as in PendingBatch.
  std::shared_ptr<UploadObserver> observer;
};

/// Frames that one batch may hold.
inline constexpr int kMaxBatchFrames = 256;

/// OK if the numbering of a batch is sound: 1 to `kMaxBatchFrames` frames, and client sequences
/// from 1 that do not overflow. Errors: `InvalidArgument` with the field relative to the batch.
/// Cheap.
absl::Status CheckNumbering(const v1::FrameBatch& batch);

/// Client sequence of the last frame of a batch that passed `CheckNumbering`.
ClientSequence LastSequenceOf(const v1::FrameBatch& batch);

/// A batch that was read and is not decoded yet.
struct ReadBatch {
  v1::FrameBatch frames;
  FrameBudget::Reservation memory;  ///< That the message takes.
};

/// Takes one batch in, on a worker pool: compares the checksum, leaves out what is durable already,
/// decodes and validates the rest frame by frame within the map's byte budget, and hands it to the
/// map's queue. While the budget is used up no thread waits: the batch goes on when it can.
class BatchIntake : public std::enable_shared_from_this<BatchIntake> {
 public:
  /// OK once every frame is in the queue or was refused; else why the upload cannot go on:
  /// `DataLoss` with reason `CHECKSUM` (then nothing of the batch was taken), `QUEUE_FULL`, or what
  /// the map refuses uploads with.
  using Done = std::function<void(const absl::Status&)>;

  /// Starts; calls `done` once, from a thread of the pool or whoever frees budget. `batch` must
  /// have passed `CheckNumbering`. `pool` must outlive the batch.
  static void Start(WorkerPool* pool, UploadRoute route, ReadBatch batch, Done done);

  /// Use `Start`.
  BatchIntake(WorkerPool* pool, UploadRoute route, ReadBatch batch, Done done);

  /// Calls `done` if nobody has: a map that closes drops those who wait for its budget.
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
  const FrameBudget::Reservation memory_;  ///< Of the message.
  v1::FrameBatch batch_;
  const std::uint64_t batch_bytes_;
  Done done_;

  int next_ = 0;                          ///< Frame to be looked at next.
  int handed_over_ = 0;                   ///< Frames before this one are in the queue.
  ClientSequence predecessor_;            ///< Of the next piece.
  FrameBudget::Reservation reservation_;  ///< For the next frame, where it had to be waited for.
  std::vector<PendingFrame> frames_;
  std::vector<RefusedFrame> refused_;
};

}  // namespace steadymap

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "core/frame/frame.h"
#include "core/types/identifiers.h"
#include "server/process/frame_budget.h"
#include "server/store/model/store.h"

namespace steadymap {

/// A frame that was refused.
struct RefusedFrame {
  ClientSequence sequence;
  absl::Status status;  ///< Its field path is relative to the batch.
};

/// The progress of a batch part.
struct BatchProgress {
  ClientSequence through;     ///< Last client sequence of the part.
  MapSequence map_seq;        ///< Newest frame of the part, or of the session; 0: none.
  Revision revision;          ///< Once integrated: a revision that contains it.
  std::size_t frames = 0;     ///< Frames of the part, including refused and repeated ones.
  std::uint64_t bytes = 0;    ///< Serialized bytes of the client's flow-control credit.
  bool ends_session = false;  ///< As the part: the decisions on the session are in the map.
};

/// The sender of frames, informed about their progress. Called from any thread, without locks held.
/// A report about a part also applies to all earlier parts; reports may arrive out of order.
class UploadObserver {
 public:
  virtual ~UploadObserver() = default;

  /// True if the sender no longer waits: frames that are not validated yet may be dropped.
  virtual bool IsAbandoned() const = 0;

  /// The frames up to `through` were validated; `refused` lists those that were not accepted.
  virtual void OnReceived(ClientSequence through, std::vector<RefusedFrame> refused) = 0;

  /// The part is in the log.
  virtual void OnDurable(const BatchProgress& progress) = 0;

  /// The part is in a committed revision.
  virtual void OnIntegrated(const BatchProgress& progress) = 0;

  /// The processing of the part has ended with an error. Durable frames stay in the log.
  virtual void OnFailed(const absl::Status& status) = 0;
};

/// A validated frame that waits for the log.
struct PendingFrame {
  ClientSequence sequence;
  Frame frame;
  std::string packed;  ///< The serialized `v1::Frame`, for the log.
  FrameBudget::Reservation reservation;
};

/// A batch, or a part of one, that waits for the log. A part without frames only contains client
/// sequences that were refused or are known already, or the end of the session.
struct PendingBatch {
  SessionName session;
  /// True for a stream, which sends sequences in ascending order: missing sequences below `last`
  /// never follow.
  bool in_order = false;
  /// If `in_order`: the last sequence of the stream's previous part; 0: there was none. If that
  /// part was not stored, this one must not be stored either, because its acknowledgement covers
  /// both.
  ClientSequence predecessor;
  ClientSequence last;
  std::vector<PendingFrame> frames;
  std::vector<ClientSequence> refused;
  /// True if the session of the robot ends after the frames: the map decides what it has seen.
  bool ends_session = false;
  std::size_t credit_frames = 0;
  std::uint64_t credit_bytes = 0;
  std::shared_ptr<UploadObserver> observer;
};

}  // namespace steadymap

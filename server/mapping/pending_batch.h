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
  absl::Status status;  ///< The field path is relative to the batch.
};

/// How far a piece of an upload has come.
struct BatchProgress {
  ClientSequence through;   ///< Last client sequence of the piece.
  MapSequence map_seq;      ///< Of the newest frame that it stands for; 0: there is none.
  Revision revision;        ///< Once integrated: a revision that shows it.
  std::size_t frames = 0;   ///< Frames of the piece, refused and repeated ones included.
  std::uint64_t bytes = 0;  ///< Serialized bytes that it took of the client's credit.
};

/// Whoever sent frames and wants to know what becomes of them. Calls come from any thread, without
/// locks held. What holds for a piece holds for all before it; word of it may come in another
/// order.
class UploadObserver {
 public:
  virtual ~UploadObserver() = default;

  /// Whether nobody waits any more: frames that are not validated yet may be dropped.
  virtual bool IsAbandoned() const = 0;

  /// The frames up to `through` were validated; `refused` are those among them that were not taken.
  virtual void OnReceived(ClientSequence through, std::vector<RefusedFrame> refused) = 0;

  /// The piece is in the log.
  virtual void OnDurable(const BatchProgress& progress) = 0;

  /// The piece is part of a committed revision.
  virtual void OnIntegrated(const BatchProgress& progress) = 0;

  /// The piece will not get further. Durable frames stay in the log all the same.
  virtual void OnFailed(const absl::Status& status) = 0;
};

/// A validated frame on its way to the log.
struct PendingFrame {
  ClientSequence sequence;
  Frame frame;
  std::string packed;  ///< The serialized `v1::Frame`, for the log.
  FrameBudget::Reservation reservation;
};

/// A piece of an upload on its way to the log: at most a batch. Without frames it only carries
/// client sequences that were refused or are known already.
struct PendingBatch {
  SessionName session;
  /// Sequences of the upload come in order (a stream): those that are left out below `last` never
  /// will.
  bool in_order = false;
  /// In order: the last sequence of the stream's piece before; 0: there was none. Where that piece
  /// was not stored, this one must not be either: acknowledging it would acknowledge both.
  ClientSequence predecessor;
  ClientSequence last;
  std::vector<PendingFrame> frames;
  std::vector<ClientSequence> refused;
  std::size_t credit_frames = 0;
  std::uint64_t credit_bytes = 0;
  std::shared_ptr<UploadObserver> observer;
};

}  // namespace steadymap

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include <absl/status/status.h>

#include "server/mapping/pending_batch.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// A refused frame on the wire.
v1::RefusedFrame ToProto(const RefusedFrame& refused);

/// What an upload stream still has to tell its client: acknowledgements and credit. Keeps the
/// newest word of each kind only, so a client that reads slowly costs nothing. Pure state.
class UploadResponses {
 public:
  /// Credit that a client has to begin with, and gets back.
  struct Window {
    std::uint64_t frames = 0;
    std::uint64_t bytes = 0;
  };

  explicit UploadResponses(Window window) : window_(window), available_(window) {}

  /// Chooses the levels to acknowledge. Errors: `InvalidArgument` with the field `ack_levels[i]`.
  absl::Status ChooseLevels(const v1::UploadOpen& open);

  /// What the client has to begin with.
  v1::UploadCredit initial_credit() const;

  /// The client has used credit. Errors: `ResourceExhausted` with reason `QUEUE_FULL` if it has
  /// less than that; it is then unchanged.
  absl::Status Spend(std::uint64_t frames, std::uint64_t bytes);

  void NoteReceived(ClientSequence through, std::vector<RefusedFrame> refused);
  void NoteDurable(const BatchProgress& progress);

  /// Gives the credit of the piece back, too.
  void NoteIntegrated(const BatchProgress& progress);

  bool HasNext() const;

  /// The next message: acknowledgements in the order of their levels, then credit.
  v1::UploadFramesResponse TakeNext();

 private:
  static constexpr std::size_t kLevels = 3;

  /// An acknowledgement that is due.
  struct Level {
    bool wanted = false;
    bool due = false;
    BatchProgress progress;
  };

  void Note(std::size_t level, const BatchProgress& progress);
  v1::UploadFramesResponse TakeAck(std::size_t level);
  v1::UploadFramesResponse TakeCredit();

  Window window_;
  Window available_;  ///< What the client holds.
  Window returned_;   ///< What it gets with the next message of credit.
  std::array<Level, kLevels> levels_;
  std::deque<RefusedFrame> refused_;  ///< Not reported yet; bounded by the window.
};

}  // namespace steadymap

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

/// Converts a refused frame to its wire message.
v1::RefusedFrame ToProto(const RefusedFrame& refused);

/// The pending messages of an upload stream to its client: acknowledgements and credit. Keeps only
/// the newest message of each kind, so a slow client uses no additional memory. Pure state without
/// I/O. Not thread-safe.
class UploadResponses {
 public:
  /// Flow-control credit that a client has at the start.
  struct Window {
    std::uint64_t frames = 0;
    std::uint64_t bytes = 0;
  };

  explicit UploadResponses(Window window) : window_(window), available_(window) {}

  /// Selects the acknowledgement levels. Errors: `InvalidArgument` with the field `ack_levels[i]`.
  absl::Status ChooseLevels(const v1::UploadOpen& open);

  /// Returns the credit of the client at the start.
  v1::UploadCredit initial_credit() const;

  /// Records that the client has used credit. Errors: `ResourceExhausted` with reason `QUEUE_FULL`
  /// if the client has less credit; the credit is then unchanged.
  absl::Status Spend(std::uint64_t frames, std::uint64_t bytes);

  void NoteReceived(ClientSequence through, std::vector<RefusedFrame> refused);
  void NoteDurable(const BatchProgress& progress);

  /// Records the integration of a part and returns its credit to the client.
  void NoteIntegrated(const BatchProgress& progress);

  bool HasNext() const;

  /// Returns the next message: acknowledgements in the order of their levels, then credit.
  v1::UploadFramesResponse TakeNext();

 private:
  static constexpr std::size_t kLevels = 3;

  /// A pending acknowledgement.
  struct Level {
    bool wanted = false;
    bool due = false;
    BatchProgress progress;
  };

  void Note(std::size_t level, const BatchProgress& progress);
  v1::UploadFramesResponse TakeAck(std::size_t level);
  v1::UploadFramesResponse TakeCredit();

  Window window_;
  Window available_;  ///< Credit that the client has.
  Window returned_;   ///< Credit of the next credit message.
  std::array<Level, kLevels> levels_;
  std::deque<RefusedFrame> refused_;  ///< Not reported yet; bounded by the window.
};

}  // namespace steadymap

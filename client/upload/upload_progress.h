#pragma once

#include <cstdint>

#include <absl/status/status.h>

namespace steadymap {

/// Where an upload stands. All counts are of frames since the start; a frame that was refused or
/// lost counts there and nowhere behind `pushed`. Only `durable` and `integrated` may fall: when
/// the server has lost frames that it had acknowledged.
struct UploadProgress {
  std::uint64_t pushed = 0;
  std::uint64_t sent = 0;        ///< Sent at least once.
  std::uint64_t durable = 0;     ///< Would survive the server's death.
  std::uint64_t integrated = 0;  ///< Part of a committed revision.
  std::uint64_t refused = 0;
  std::uint64_t lost = 0;        ///< Were durable, are no more and were not sent again.
  std::uint64_t sent_again = 0;  ///< Sendings beyond the first, after reconnections.
  std::uint64_t reconnections = 0;
  std::uint64_t bytes_sent = 0;  ///< Of serialized batches.
  /// Newest revision that an acknowledgement named; where frames were integrated by an earlier
  /// stream, whose acknowledgements did not come, that of the map when this was found out.
  std::uint64_t revision = 0;

  friend bool operator==(const UploadProgress&, const UploadProgress&) = default;
};

/// Frames that the server had acknowledged as durable and no longer has, as after its disk was set
/// back to an older copy: those with the client sequences from `first` to `last`, both included.
struct LostFrames {
  std::uint64_t first = 0;
  std::uint64_t last = 0;

  friend bool operator==(const LostFrames&, const LostFrames&) = default;
};

/// A frame that the server refused.
struct RefusedUpload {
  std::uint64_t client_seq = 0;  ///< The k-th frame pushed has k.
  absl::Status status;           ///< With reason and field path.
};

}  // namespace steadymap

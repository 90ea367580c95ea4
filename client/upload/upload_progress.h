#pragma once

#include <cstdint>

#include <absl/status/status.h>

namespace steadymap {

/// Progress of an upload. All counts are frames since the start of the upload. A refused or lost
/// frame is counted in `refused` or `lost` and in no count after `pushed`. Only `durable` and
/// `integrated` can decrease, when the server has lost acknowledged frames.
struct UploadProgress {
  std::uint64_t pushed = 0;
  std::uint64_t sent = 0;        ///< Sent at least once.
  std::uint64_t durable = 0;     ///< Stored on the server's disk.
  std::uint64_t integrated = 0;  ///< Part of a committed revision.
  std::uint64_t refused = 0;
  std::uint64_t lost = 0;        ///< Were durable, are missing on the server, not resent.
  std::uint64_t sent_again = 0;  ///< Repeated transmissions after reconnections.
  std::uint64_t reconnections = 0;
  std::uint64_t bytes_sent = 0;  ///< Bytes of serialized batches.
  /// Newest revision named by an acknowledgement. If an earlier stream integrated the frames and
  /// its acknowledgements were lost: the revision of the map when the client confirmed the
  /// integration.
  std::uint64_t revision = 0;

  friend bool operator==(const UploadProgress&, const UploadProgress&) = default;
};

/// Frames with the client sequences `first` to `last`, both included, that the server had
/// acknowledged as durable and no longer has, e.g. after its disk was restored from an older copy.
struct LostFrames {
  std::uint64_t first = 0;
  std::uint64_t last = 0;

  friend bool operator==(const LostFrames&, const LostFrames&) = default;
};

/// A frame that the server refused.
struct RefusedUpload {
  std::uint64_t client_seq = 0;  ///< 1 for the first frame pushed.
  absl::Status status;           ///< Includes reason and field path.
};

}  // namespace steadymap

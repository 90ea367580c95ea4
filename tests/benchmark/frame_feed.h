#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "client/bench/simulator/simulation.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap::benchmarks {

using Clock = std::chrono::steady_clock;

/// The first report of a revision.
struct Sighting {
  Clock::time_point time;
  std::uint64_t revision = 0;
};

/// Frames ready for upload.
struct PackedDrive {
  std::vector<v1::Frame> frames;         ///< 640 x 360, depth and labels as PNG.
  std::vector<std::size_t> sequence_of;  ///< Sequence of the route, for each frame.
};

/// Renders and packs the first `max_frames` frames of a route; 0: all. About 40 frames per second.
PackedDrive PackDrive(Route route, const SimulationOptions& options, std::size_t max_frames);

/// Returns the mean size of a packed frame.
double MeanFrameBytes(const std::vector<v1::Frame>& frames);

/// Measurements of an upload.
struct FeedRecord {
  std::vector<Clock::time_point> pushed;  ///< Time of the push of each frame.
  std::vector<Sighting> commits;          ///< From the acknowledgements of the uploader.
  double seconds = 0.0;                   ///< From the first frame to INTEGRATED of the last.

  double frames_per_second() const { return static_cast<double>(pushed.size()) / seconds; }
};

/// Uploads frames into an empty map at `rate_hz`, or as fast as the server accepts them if
/// `rate_hz` is 0. Frame k gets the map sequence k + 1. Throws `std::runtime_error` unless all are
/// integrated.
FeedRecord FeedFrames(const std::string& address,
                      const MapName& map,
                      const std::vector<v1::Frame>& frames,
                      double rate_hz);

}  // namespace steadymap::benchmarks

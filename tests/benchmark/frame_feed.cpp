#include "tests/benchmark/frame_feed.h"

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "client/bench/simulator/simulated_frame_source.h"
#include "client/transport/channel.h"
#include "client/upload/uploader.h"
#include "core/frame/image_codec.h"

namespace steadymap::benchmarks {

PackedDrive PackDrive(Route route, const SimulationOptions& options, std::size_t max_frames) {
  Simulation simulation(std::move(route), options);
  PackedDrive drive;
  const std::size_t count =
      max_frames == 0 ? simulation.frame_count() : std::min(max_frames, simulation.frame_count());
  for (std::size_t i = 0; i < count; ++i) {
    const Frame frame = simulation.Render(i);
    v1::Frame message = PackSimulatedFrame(frame);
    message.mutable_depth()->set_encoding(v1::DEPTH_ENCODING_PNG_UINT16);
    message.mutable_depth()->set_data(EncodePixels(frame.depth.units, PixelEncoding::kPng));
    message.mutable_labels()->set_encoding(v1::LABEL_ENCODING_PNG);
    message.mutable_labels()->set_data(EncodePixels(frame.labels, PixelEncoding::kPng));
    drive.frames.push_back(std::move(message));
    drive.sequence_of.push_back(simulation.SequenceOf(i));
  }
  return drive;
}

double MeanFrameBytes(const std::vector<v1::Frame>& frames) {
  std::size_t bytes = 0;
  for (const v1::Frame& frame : frames) bytes += frame.ByteSizeLong();
  return static_cast<double>(bytes) / static_cast<double>(std::max<std::size_t>(frames.size(), 1));
}

FeedRecord FeedFrames(const std::string& address,
                      const MapName& map,
                      const std::vector<v1::Frame>& frames,
                      double rate_hz) {
  std::vector<v1::Frame> copies = frames;
  FeedRecord record;
  record.pushed.reserve(frames.size());
  std::mutex mutex;
  std::vector<Sighting> commits;  // Guarded by `mutex`.
  UploaderOptions options;
  options.on_progress = [&mutex, &commits](const UploadProgress& progress) {
    const std::lock_guard lock(mutex);
    if (progress.revision > (commits.empty() ? 0 : commits.back().revision)) {
      commits.push_back({Clock::now(), progress.revision});
    }
  };
  FrameUploader uploader(ChannelsTo(address), map, options);
  const Clock::time_point start = Clock::now();
  for (std::size_t i = 0; i < copies.size(); ++i) {
    if (rate_hz > 0.0) {
      const std::chrono::duration<double> since_start(static_cast<double>(i) / rate_hz);
      std::this_thread::sleep_until(start +
                                    std::chrono::duration_cast<Clock::duration>(since_start));
    }
    record.pushed.push_back(Clock::now());
    if (const absl::Status status = uploader.Push(std::move(copies[i])); !status.ok()) {
      throw std::runtime_error(status.ToString());
    }
  }
  const absl::StatusOr<UploadSummary> summary = uploader.Finish();
  record.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  if (!summary.ok()) throw std::runtime_error(summary.status().ToString());
  if (!summary->refused.empty()) throw std::runtime_error("frames were refused");
  const std::lock_guard lock(mutex);
  record.commits = std::move(commits);
  return record;
}

}  // namespace steadymap::benchmarks

#include "tests/benchmark/kitchen_frames.h"

#include <cstdlib>
#include <filesystem>
#include <utility>

#include "client/dataset/dataset.h"
#include "core/types/map_config.h"
#include "proto/convert_frame.h"

namespace steadymap::benchmarks {
namespace {

constexpr int kHeightPx = 360;

void CropToMiddle(Frame* frame) {
  const int top_px = (frame->depth.units.height_px() - kHeightPx) / 2;
  Image<std::uint16_t> cropped(frame->depth.units.width_px(), kHeightPx);
  for (int v = 0; v < kHeightPx; ++v) {
    for (int u = 0; u < cropped.width_px(); ++u) {
      cropped.At(u, v) = frame->depth.units.At(u, v + top_px);
    }
  }
  frame->depth.units = std::move(cropped);
  frame->camera.height_px = kHeightPx;
  frame->camera.cy -= top_px;
}

}  // namespace

std::vector<Frame> LoadKitchenFrames(std::size_t count) {
  // This process does not modify its environment.
  const char* shared_data = std::getenv("STEADYMAP_SHARED_DATA");  // NOLINT(concurrency-mt-unsafe)
  const std::filesystem::path folder =
      std::filesystem::path(shared_data != nullptr ? shared_data : STEADYMAP_SHARED_DATA) /
      "7scenes-kitchen";
  DatasetOptions options;
  options.include_color = false;
  absl::StatusOr<std::unique_ptr<DatasetSource>> source =
      OpenDataset("seven-scenes", {folder}, options);
  std::vector<Frame> frames;
  while (source.ok() && frames.size() < count) {
    const absl::StatusOr<std::optional<v1::Frame>> message = (*source)->Next();
    if (!message.ok() || !message->has_value()) break;
    absl::StatusOr<Frame> frame = FromProto(
        **message, {"robot", SensorName::kDefaultSensor}, KnownLabels(MapConfig().classes));
    if (!frame.ok()) break;
    CropToMiddle(&*frame);
    frames.push_back(*std::move(frame));
  }
  return frames;
}

}  // namespace steadymap::benchmarks

#include "client/bench/simulator/simulated_frame_source.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "client/bench/simulator/routes/named_routes.h"
#include "client/dataset/frame_message.h"
#include "core/frame/image_codec.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

void PackLabels(const Image<std::uint16_t>& image, v1::LabelImage* message) {
  const std::uint16_t largest = *std::max_element(image.data(), image.data() + image.size());
  const bool is_narrow = largest <= std::numeric_limits<std::uint8_t>::max();
  message->set_encoding(is_narrow ? v1::LABEL_ENCODING_ZSTD_UINT8 : v1::LABEL_ENCODING_ZSTD_UINT16);
  message->set_data(
      EncodePixels(image, is_narrow ? PixelEncoding::kZstdUint8 : PixelEncoding::kZstdUint16));
}

}  // namespace

v1::Frame PackSimulatedFrame(const Frame& frame) {
  v1::Frame message;
  FillFrameMessage(frame.capture_time, frame.camera, frame.T_world_camera, &message);
  message.mutable_depth()->set_encoding(v1::DEPTH_ENCODING_ZSTD_UINT16);
  message.mutable_depth()->set_metres_per_unit(frame.depth.metres_per_unit);
  message.mutable_depth()->set_sensor(v1::DEPTH_SENSOR_STEREO);
  message.mutable_depth()->set_data(EncodePixels(frame.depth.units, PixelEncoding::kZstdUint16));
  if (!frame.labels.empty()) PackLabels(frame.labels, message.mutable_labels());
  if (!frame.instances.empty()) PackLabels(frame.instances, message.mutable_instances());
  if (!frame.color.empty()) {
    message.mutable_color()->set_encoding(v1::COLOR_ENCODING_PNG);
    message.mutable_color()->set_data(EncodeColorPng(frame.color));
  }
  return message;
}

SimulatedFrameSource::SimulatedFrameSource(Route route, SimulationOptions options)
    : simulation_(std::move(route), std::move(options)) {}

absl::StatusOr<std::unique_ptr<SimulatedFrameSource>> SimulatedFrameSource::Open(
    std::string_view route_name, const SimulationOptions& options) {
  if (options.stride < 1) {
    return InvalidField(reason::kBadValue, "stride", "stride must be at least 1, got 0");
  }
  absl::StatusOr<Route> route = MakeRoute(route_name);
  if (!route.ok()) return route.status();
  return std::make_unique<SimulatedFrameSource>(*std::move(route), options);
}

absl::StatusOr<std::optional<v1::Frame>> SimulatedFrameSource::Next() {
  if (next_index_ == simulation_.frame_count()) return std::optional<v1::Frame>();
  return std::optional<v1::Frame>(PackSimulatedFrame(simulation_.Render(next_index_++)));
}

absl::StatusOr<v1::Frame> SimulatedFrameSource::Read(std::size_t index) {
  if (index >= simulation_.frame_count()) return NoFrameAt(index, simulation_.frame_count());
  return PackSimulatedFrame(simulation_.Render(index));
}

}  // namespace steadymap

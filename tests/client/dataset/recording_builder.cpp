#include "tests/client/dataset/recording_builder.h"

#include <absl/strings/str_format.h>
#include <gtest/gtest.h>

#include "core/frame/image_codec.h"

namespace steadymap {

void WriteTorwicRecording(const TemporaryFolder& folder,
                          const std::string& name,
                          const TorwicRecording& recording) {
  std::string poses;
  for (int i = 0; i < recording.frame_count; ++i) {
    const auto file = [&](const char* kind) {
      return absl::StrFormat("%s/%s/%04d.png", name, kind, i);
    };
    folder.Write(file("Depth"), DepthPng(640, 360, static_cast<std::uint16_t>(1000 + i)));
    const Image<std::uint16_t> labels(640, 360, recording.label);
    folder.Write(file("Segmentation"), EncodePixels(labels, PixelEncoding::kPng));
    if (recording.has_color) {
      folder.Write(file("RGB"), EncodeColorPng(Image<Rgb>(640, 360, {1, 2, 3})));
    }
    absl::StrAppendFormat(
        &poses, "%d 1600000000 %d %.6f 0 0 0 0 0 1\n", i, 100'000'000 * i, recording.x_m + 0.1 * i);
  }
  folder.Write(name + "/poses.txt", poses);
}

std::string DepthPng(int width_px, int height_px, std::uint16_t value) {
  return EncodePixels(Image<std::uint16_t>(width_px, height_px, value), PixelEncoding::kPng, true);
}

std::vector<v1::Frame> ReadAll(std::string_view format,
                               const std::vector<std::filesystem::path>& paths,
                               const DatasetOptions& options) {
  std::vector<v1::Frame> frames;
  auto source = OpenDataset(format, paths, options);
  EXPECT_TRUE(source.ok()) << source.status();
  while (source.ok()) {
    auto frame = (*source)->Next();
    EXPECT_TRUE(frame.ok()) << frame.status();
    if (!frame.ok() || !frame->has_value()) break;
    frames.push_back(**std::move(frame));
  }
  return frames;
}

std::int64_t TimeOf(const v1::Frame& frame) {
  return frame.capture_time().seconds() * 1'000'000'000 + frame.capture_time().nanos();
}

}  // namespace steadymap

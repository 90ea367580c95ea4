#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "client/dataset/dataset.h"
#include "tests/support/temporary_folder.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// A small recording in the TorWIC layout: the robot moves along x, 0.1 m per frame, facing +x.
struct TorwicRecording {
  int frame_count = 1;
  std::uint16_t label = 7;  ///< Of every pixel.
  double x_m = 0.0;         ///< Start position of the robot.
  bool has_color = false;
};

/// Writes `recording` as `name` below `folder`. Every recording starts at the same time.
void WriteTorwicRecording(const TemporaryFolder& folder,
                          const std::string& name,
                          const TorwicRecording& recording);

/// Returns a 16-bit PNG file of this size with every pixel equal to `value`.
std::string DepthPng(int width_px, int height_px, std::uint16_t value);

/// Opens a recording and reads all its frames; fails the test at the first error.
std::vector<v1::Frame> ReadAll(std::string_view format,
                               const std::vector<std::filesystem::path>& paths,
                               const DatasetOptions& options);

/// Returns the capture time, nanoseconds since 1970.
std::int64_t TimeOf(const v1::Frame& frame);

}  // namespace steadymap

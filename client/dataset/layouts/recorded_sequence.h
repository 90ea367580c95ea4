#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"
#include "core/geometry/geometry.h"
#include "core/types/timestamp.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// Frame period of a Kinect, for recordings without times.
inline constexpr std::int64_t kKinectPeriodNs = 33'333'333;

/// Latest time of a recording with times in seconds: a double has microsecond resolution up to
/// here.
inline constexpr double kMaxRecordedSeconds = 9e9;

/// One frame of a recording: its image files and its camera pose.
struct RecordedFrame {
  Timestamp time;
  /// Pose in the recording's own world frame, or the error if the recorded pose cannot be read.
  absl::StatusOr<Eigen::Isometry3d> T_dataset_camera = Eigen::Isometry3d::Identity();
  std::filesystem::path depth;   ///< A file for `PackDepthFile`.
  std::filesystem::path labels;  ///< A PNG file; empty: none.
  /// A file for `SegmentClasses`, if the pixels of `labels` are segments; empty: they are classes.
  std::filesystem::path segment_classes;
  std::filesystem::path instances;  ///< A PNG file; empty: none.
  std::filesystem::path color;      ///< A PNG or JPEG file; empty: none.
};

/// The index of one sequence.
struct RecordedSequence {
  PinholeCamera camera;
  double metres_per_unit = 0.001;  ///< Unit of depth images.
  v1::DepthSensor depth_sensor = v1::DEPTH_SENSOR_UNSPECIFIED;
  /// Transforms the recording's world frame to one with z up. The options can replace it.
  Eigen::Isometry3d T_world_dataset = Eigen::Isometry3d::Identity();
  std::vector<RecordedFrame> frames;  ///< In recording order.
  std::size_t skipped_count = 0;  ///< Number of frames omitted because they have no finite pose.
};

/// The detection and indexing of one format.
struct DatasetFormat {
  std::string_view name;
  std::string_view expected;  ///< Files that a sequence must contain, for messages.
  bool (*is_sequence)(const std::filesystem::path& folder);
  /// Indexes a folder for which `is_sequence` returns true.
  absl::StatusOr<RecordedSequence> (*index)(const std::filesystem::path& folder);
  bool has_depth_unit = true;  ///< True: depth images contain integer units. False: metres.
};

}  // namespace steadymap

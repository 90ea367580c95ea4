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

namespace steadymap {

/// From one frame to the next of a Kinect, for recordings that carry no times.
inline constexpr std::int64_t kKinectPeriodNs = 33'333'333;

/// Latest time of a recording that says it in seconds: what a double holds to a microsecond.
inline constexpr double kMaxRecordedSeconds = 9e9;

/// One frame of a recording: where its images lie, and where the camera was.
struct RecordedFrame {
  Timestamp time;
  /// In the recording's own world; or why it is not known although the recording tells it.
  absl::StatusOr<Eigen::Isometry3d> T_dataset_camera = Eigen::Isometry3d::Identity();
  std::filesystem::path depth;   ///< What `PackDepthFile` reads.
  std::filesystem::path labels;  ///< A PNG file; empty: none.
  /// What `SegmentClasses` reads, if the pixels of `labels` are segments; empty: they are classes.
  std::filesystem::path segment_classes;
  std::filesystem::path instances;  ///< A PNG file; empty: none.
  std::filesystem::path color;      ///< A PNG or JPEG file; empty: none.
};

/// The index of one sequence.
struct RecordedSequence {
  PinholeCamera camera;
  double metres_per_unit = 0.001;  ///< Of depth images.
  /// To a world with z up, unless the options say otherwise.
  Eigen::Isometry3d T_world_dataset = Eigen::Isometry3d::Identity();
  std::vector<RecordedFrame> frames;  ///< In the order of recording.
  std::size_t skipped_count = 0;      ///< Frames left out because they have no finite pose.
};

/// How one format is recognised and indexed.
struct DatasetFormat {
  std::string_view name;
  std::string_view expected;  ///< What makes a folder a sequence, for messages.
  bool (*is_sequence)(const std::filesystem::path& folder);
  /// Indexes a folder for which `is_sequence` holds.
  absl::StatusOr<RecordedSequence> (*index)(const std::filesystem::path& folder);
  bool has_depth_unit = true;  ///< Depth images hold whole units; else metres.
};

}  // namespace steadymap

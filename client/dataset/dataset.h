#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "client/dataset/recording_check.h"
#include "client/upload/frame_source.h"

namespace steadymap {

/// Options for reading a recorded data set.
struct DatasetOptions {
  std::size_t stride = 1;  ///< Every `stride`-th frame is read, >= 1.
  /// A label map file (see `label_map.h`) that converts the recording's classes to the map's.
  /// Empty: labels are not changed.
  std::filesystem::path label_map_file = {};
  /// A text file with the 4x4 matrix `T_world_dataset`, row by row, which transforms the
  /// recording's world frame to the map's (z up). Empty: the transform defined by the format.
  std::filesystem::path T_world_dataset_file = {};
  bool include_color = true;  ///< True: colour images are included in the frames.
  /// Metres per unit of depth images, in [1e-6, 0.1]. Replaces the unit defined by the format. Only
  /// for formats whose depth has units (`HasDepthUnit`).
  std::optional<double> metres_per_unit = std::nullopt;
  /// The camera's fx, fy, cx and cy, pixels. Replaces the intrinsics of the format or of the
  /// recording. Only for formats whose depth has units (`HasDepthUnit`). The image size is that of
  /// the first depth image.
  std::optional<std::array<double, 4>> intrinsics = std::nullopt;
  /// The depth sensor. Replaces that of the format.
  std::optional<v1::DepthSensor> depth_sensor = std::nullopt;
};

/// A recording on disk as a source of frames. Only its index is kept in memory, never its images.
class DatasetSource : public FrameSource {
 public:
  /// Returns the number of frames that are skipped because their pose is missing or contains NaN or
  /// infinity.
  virtual std::size_t skipped_count() const = 0;

  /// Reads the depth of up to `frame_count` frames, evenly spaced from the first to the last. Skips
  /// frames with unreadable depth. Does not change the position of `Next`.
  virtual RecordingSample Sample(std::size_t frame_count) const = 0;
};

/// Returns the names of the formats that `OpenDataset` supports.
std::vector<std::string> DatasetFormats();

/// True if the depth images of a format contain integer units, whose length depends on the camera.
/// False if they contain metres, and for an unknown format.
bool HasDepthUnit(std::string_view format);

/// Opens a recording.
///
/// `format` is `torwic`, `seven-scenes`, `tum`, `co-fusion` or `panoptic`. Each path is the folder
/// of a sequence, or a folder that contains several. Sequences are played one after the other, in
/// natural order within a folder, and their times are shifted so that they increase from sequence
/// to sequence. Errors: `InvalidArgument` for an unknown format, no path, a stride of 0, options
/// that the format does not support or that do not describe a camera, or a malformed file;
/// `NotFound` for a path or file that is missing. The message contains the file and the expected
/// content.
absl::StatusOr<std::unique_ptr<DatasetSource>> OpenDataset(
    std::string_view format,
    const std::vector<std::filesystem::path>& paths,
    const DatasetOptions& options);

}  // namespace steadymap

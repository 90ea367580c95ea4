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

/// How a recorded data set is read.
struct DatasetOptions {
  std::size_t stride = 1;  ///< Every how many frames one is kept, >= 1.
  /// A label map file (see `label_map.h`) that turns the recording's classes into the map's. Empty:
  /// labels pass unchanged.
  std::filesystem::path label_map_file = {};
  /// A text file with the 4x4 matrix `T_world_dataset`, row by row, which takes the recording's
  /// world to the map's (z up). Empty: what the format prescribes.
  std::filesystem::path T_world_dataset_file = {};
  bool include_color = true;  ///< Whether colour images are sent along.
  /// Metres per unit of depth images, in [1e-6, 0.1], instead of what the format prescribes. Only
  /// for formats whose depth has units (`HasDepthUnit`).
  std::optional<double> metres_per_unit = std::nullopt;
  /// The camera's fx, fy, cx and cy, pixels, instead of what the format or the recording says. Only
  /// for the same formats; images are as large as the first depth image.
  std::optional<std::array<double, 4>> intrinsics = std::nullopt;
};

/// A recording on disk as frames. Only its index is held in memory, never its images.
class DatasetSource : public FrameSource {
 public:
  /// Frames found so far that no pose could be given to: it holds NaN or infinity, or there is
  /// none.
  virtual std::size_t skipped_count() const = 0;

  /// Looks at the depth of up to `frame_count` frames, spread evenly from the first frame to the
  /// last. Frames whose depth cannot be read are passed over. `Next` goes on where it was.
  virtual RecordingSample Sample(std::size_t frame_count) const = 0;
};

/// The names of the formats that `OpenDataset` reads.
std::vector<std::string> DatasetFormats();

/// Whether the depth images of a format hold whole units, whose length depends on the camera,
/// rather than metres. False for an unknown format.
bool HasDepthUnit(std::string_view format);

/// Opens a recording.
///
/// `format` is `torwic`, `seven-scenes`, `tum`, `co-fusion` or `panoptic`. Each path is a
/// sequence's folder or a folder that holds several; sequences are played one after the other, in
/// natural order within a folder, and their times are moved so that they keep increasing. Errors:
/// `InvalidArgument` for an unknown format, no path, a stride of 0, options that do not suit the
/// format or make no camera, or a malformed file; `NotFound`
/// for a path or file that is missing. The message names the file and what was expected.
absl::StatusOr<std::unique_ptr<DatasetSource>> OpenDataset(
    std::string_view format,
    const std::vector<std::filesystem::path>& paths,
    const DatasetOptions& options);

}  // namespace steadymap

#include "client/dataset/dataset.h"

#include <algorithm>
#include <array>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include "client/dataset/files/folder_listing.h"
#include "client/dataset/files/image_file.h"
#include "client/dataset/files/text_file.h"
#include "client/dataset/layouts/co_fusion_sequence.h"
#include "client/dataset/layouts/panoptic_sequence.h"
#include "client/dataset/layouts/recorded_sequence.h"
#include "client/dataset/layouts/seven_scenes_sequence.h"
#include "client/dataset/layouts/torwic_sequence.h"
#include "client/dataset/layouts/tum_sequence.h"
#include "client/dataset/recorded_frame_source.h"
#include "core/types/absl_text.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;

std::array<DatasetFormat, 5> Formats() {
  return {TorwicFormat(), SevenScenesFormat(), TumFormat(), CoFusionFormat(), PanopticFormat()};
}

absl::StatusOr<DatasetFormat> FindFormat(std::string_view name) {
  for (const DatasetFormat& format : Formats()) {
    if (format.name == name) return format;
  }
  return absl::InvalidArgumentError(absl::StrCat("expected one of the formats ",
                                                 absl::StrJoin(DatasetFormats(), ", "),
                                                 ", found \"",
                                                 std::string(name.substr(0, 80)),
                                                 "\""));
}

// Returns the sequence folders of a path: the path itself, or the sequences directly inside it.
absl::StatusOr<std::vector<fs::path>> FindSequences(const DatasetFormat& format,
                                                    const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    return absl::NotFoundError(absl::StrCat(path.string(), ": expected a folder, found none"));
  }
  if (format.is_sequence(path)) return std::vector<fs::path>{path};
  std::vector<fs::path> folders = ListFolders(path);
  std::erase_if(folders, [&format](const fs::path& folder) { return !format.is_sequence(folder); });
  if (!folders.empty()) return folders;
  return absl::NotFoundError(absl::StrCat(path.string(),
                                          ": expected a ",
                                          std::string(format.name),
                                          " sequence with ",
                                          std::string(format.expected)) +
                             ", or a folder of such sequences");
}

// NaN fails both comparisons.
bool IsMetresPerUnit(double metres) { return metres >= 1e-6 && metres <= 0.1; }

// Checks the options against the format, independent of any recording.
absl::Status CheckOptions(const DatasetFormat& format, const DatasetOptions& options) {
  if (options.stride < 1) return absl::InvalidArgumentError("stride must be at least 1, got 0");
  if (!format.has_depth_unit && (options.metres_per_unit || options.intrinsics)) {
    return absl::InvalidArgumentError(
        absl::StrCat("recordings in the format ",
                     Absl(format.name),
                     " contain depth in metres and the intrinsics of the camera: a depth scale "
                     "or intrinsics cannot be given"));
  }
  if (options.metres_per_unit && !IsMetresPerUnit(*options.metres_per_unit)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the depth scale must be metres per unit in [1e-6, 0.1], such as 0.001 for "
                     "millimetres, got ",
                     *options.metres_per_unit));
  }
  return absl::OkStatus();
}

// Replaces values of the recording by those given in the options.
absl::Status ApplyOptions(const DatasetOptions& options, RecordedSequence* sequence) {
  if (options.metres_per_unit) sequence->metres_per_unit = *options.metres_per_unit;
  if (options.depth_sensor) sequence->depth_sensor = *options.depth_sensor;
  if (!options.intrinsics) return absl::OkStatus();
  const absl::StatusOr<ImageFile> depth = ReadImageFile(sequence->frames.front().depth);
  if (!depth.ok()) return depth.status();
  const auto [fx, fy, cx, cy] = *options.intrinsics;
  sequence->camera = {depth->size.width_px, depth->size.height_px, fx, fy, cx, cy};
  absl::Status status = ValidateCamera(sequence->camera);
  if (status.ok()) return status;
  return absl::InvalidArgumentError(absl::StrCat("expected the intrinsics of a camera of ",
                                                 depth->size.width_px,
                                                 " x ",
                                                 depth->size.height_px,
                                                 " pixels: ",
                                                 status.message()));
}

absl::StatusOr<std::vector<RecordedSequence>> IndexSequences(const DatasetFormat& format,
                                                             const std::vector<fs::path>& paths,
                                                             const DatasetOptions& options) {
  std::vector<RecordedSequence> sequences;
  for (const fs::path& path : paths) {
    const absl::StatusOr<std::vector<fs::path>> folders = FindSequences(format, path);
    if (!folders.ok()) return folders.status();
    for (const fs::path& folder : *folders) {
      absl::StatusOr<RecordedSequence> sequence = format.index(folder);
      if (!sequence.ok()) return sequence.status();
      if (sequence->frames.empty()) {
        return absl::InvalidArgumentError(
            absl::StrCat(folder.string(), ": expected frames with a pose, found none"));
      }
      absl::Status status = ApplyOptions(options, &*sequence);
      if (!status.ok()) return status;
      sequences.push_back(*std::move(sequence));
    }
  }
  return sequences;
}

absl::StatusOr<PlaybackOptions> LoadPlaybackOptions(const DatasetOptions& options) {
  PlaybackOptions playback;
  playback.stride = options.stride;
  playback.include_color = options.include_color;
  if (!options.label_map_file.empty()) {
    absl::StatusOr<LabelMap> label_map = LabelMap::Load(options.label_map_file);
    if (!label_map.ok()) return label_map.status();
    playback.label_map = *std::move(label_map);
  }
  if (!options.T_world_dataset_file.empty()) {
    const auto T_world_dataset = ReadTransform(options.T_world_dataset_file);
    if (!T_world_dataset.ok()) return T_world_dataset.status();
    if (!T_world_dataset->matrix().allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrCat(options.T_world_dataset_file.string(), ": expected finite numbers"));
    }
    playback.T_world_dataset = *T_world_dataset;
  }
  return playback;
}

}  // namespace

std::vector<std::string> DatasetFormats() {
  std::vector<std::string> names;
  for (const DatasetFormat& format : Formats()) names.emplace_back(format.name);
  return names;
}

bool HasDepthUnit(std::string_view format) {
  const absl::StatusOr<DatasetFormat> found = FindFormat(format);
  return found.ok() && found->has_depth_unit;
}

absl::StatusOr<std::unique_ptr<DatasetSource>> OpenDataset(
    std::string_view format,
    const std::vector<std::filesystem::path>& paths,
    const DatasetOptions& options) {
  const absl::StatusOr<DatasetFormat> found = FindFormat(format);
  if (!found.ok()) return found.status();
  if (paths.empty())
    return absl::InvalidArgumentError("expected at least one path of a data set, found none");
  if (absl::Status status = CheckOptions(*found, options); !status.ok()) return status;
  absl::StatusOr<PlaybackOptions> playback = LoadPlaybackOptions(options);
  if (!playback.ok()) return playback.status();
  absl::StatusOr<std::vector<RecordedSequence>> sequences = IndexSequences(*found, paths, options);
  if (!sequences.ok()) return sequences.status();
  return std::make_unique<RecordedFrameSource>(*std::move(sequences), *std::move(playback));
}

}  // namespace steadymap

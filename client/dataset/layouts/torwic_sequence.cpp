#include "client/dataset/layouts/torwic_sequence.h"

#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

#include "client/dataset/files/folder_listing.h"
#include "client/dataset/files/text_file.h"
#include "client/dataset/layouts/torwic_layout.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;

// A line of `poses.txt`.
struct PoseLine {
  Timestamp time;
  bool is_finite = false;
  absl::StatusOr<Eigen::Isometry3d> T_map_base = Eigen::Isometry3d::Identity();
};

PoseLine ParsePoseLine(const fs::path& file, const TextLine& line) {
  constexpr char kExpected[] = "\"id sec nsec px py pz qx qy qz qw\"";
  PoseLine pose;
  pose.is_finite = true;
  const std::optional<std::vector<double>> n = ParseNumbers(line.text);
  if (!n || n->size() != 10 || !((*n)[1] >= 0 && (*n)[1] <= kMaxRecordedSeconds) ||
      !((*n)[2] >= 0 && (*n)[2] < 1e9)) {
    pose.T_map_base = MalformedLine(file, line, kExpected);
    return pose;
  }
  pose.time =
      Timestamp::FromNanoseconds(std::llround((*n)[1]) * 1'000'000'000 + std::llround((*n)[2]));
  const auto numbers = std::span(*n).subspan<3, 7>();
  pose.is_finite = AreFinite(numbers);
  if (pose.is_finite) pose.T_map_base = ParsePose(file, line, numbers);
  return pose;
}

// Returns the images of one kind, one for each depth image; empty if the recording has no such
// folder.
absl::StatusOr<std::vector<fs::path>> ListImages(const fs::path& folder,
                                                 std::string_view kind,
                                                 std::size_t expected_count) {
  const fs::path images = FindEntry(folder, kind);
  if (images.empty()) return std::vector<fs::path>();
  std::vector<fs::path> files = ListFiles(images, {".png", ".jpg", ".jpeg"});
  if (files.size() == expected_count) return files;
  return absl::InvalidArgumentError(absl::StrCat(images.string(),
                                                 ": expected ",
                                                 expected_count,
                                                 " images, one for each image in Depth, found ",
                                                 files.size()));
}

absl::StatusOr<TorwicCalibration> CalibrationOf(const fs::path& folder) {
  const fs::path file = FindEntry(folder, "calibration.txt");
  if (file.empty()) return DefaultTorwicCalibration();
  return LoadTorwicCalibration(file);
}

bool IsTorwicSequence(const fs::path& folder) {
  return !FindEntry(folder, "poses.txt").empty() && !FindEntry(folder, "depth").empty();
}

absl::StatusOr<RecordedSequence> IndexTorwicSequence(const fs::path& folder) {
  const absl::StatusOr<TorwicCalibration> calibration = CalibrationOf(folder);
  if (!calibration.ok()) return calibration.status();
  const fs::path poses_file = FindEntry(folder, "poses.txt");
  const absl::StatusOr<std::vector<TextLine>> poses = ReadTextLines(poses_file);
  if (!poses.ok()) return poses.status();
  const std::vector<fs::path> depth = ListFiles(FindEntry(folder, "depth"), {".png"});
  const auto labels = ListImages(folder, "segmentation", depth.size());
  if (!labels.ok()) return labels.status();
  const auto instances = ListImages(folder, "instances", depth.size());
  if (!instances.ok()) return instances.status();
  const auto color = ListImages(folder, "rgb", depth.size());
  if (!color.ok()) return color.status();

  RecordedSequence sequence;
  sequence.camera = calibration->camera;
  sequence.metres_per_unit = calibration->metres_per_unit;
  sequence.depth_sensor = v1::DEPTH_SENSOR_STEREO;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (i >= poses->size()) {
      ++sequence.skipped_count;
      continue;
    }
    const PoseLine pose = ParsePoseLine(poses_file, (*poses)[i]);
    if (!pose.is_finite) {
      ++sequence.skipped_count;
      continue;
    }
    RecordedFrame frame;
    frame.time = pose.time;
    frame.T_dataset_camera = pose.T_map_base;
    if (pose.T_map_base.ok()) {
      frame.T_dataset_camera = *pose.T_map_base * calibration->T_base_camera;
    }
    frame.depth = depth[i];
    if (!labels->empty()) frame.labels = (*labels)[i];
    if (!instances->empty()) frame.instances = (*instances)[i];
    if (!color->empty()) frame.color = (*color)[i];
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

}  // namespace

DatasetFormat TorwicFormat() {
  return {"torwic", "poses.txt and a folder Depth", IsTorwicSequence, IndexTorwicSequence};
}

}  // namespace steadymap

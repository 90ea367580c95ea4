#include "client/dataset/layouts/seven_scenes_sequence.h"

#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include <absl/strings/numbers.h>

#include "client/dataset/files/camera_matrix.h"
#include "client/dataset/files/folder_listing.h"
#include "client/dataset/files/text_file.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;

constexpr PinholeCamera kSevenScenesCamera = {640, 480, 585.0, 585.0, 320.0, 240.0};

// The recordings contain no times. Times are derived from frame numbers at the Kinect's frame rate,
// from an arbitrary fixed day.
constexpr std::int64_t kFirstSevenScenesNs = 1'356'998'400'000'000'000;

// Returns `frame-000012.` for `frame-000012.depth.png`.
std::string StemOf(const fs::path& depth) {
  const std::string name = depth.filename().string();
  return name.substr(0, name.find('.') + 1);
}

std::int64_t FrameNumberOf(const std::string& stem) {
  const std::size_t dash = stem.rfind('-');
  std::int64_t number = 0;
  const bool is_number =
      absl::SimpleAtoi(stem.substr(dash + 1, stem.size() - dash - 2), &number) && number >= 0;
  return is_number ? number : 0;
}

bool IsSevenScenesSequence(const fs::path& folder) {
  return !ListFiles(folder, {".depth.png"}).empty();
}

// The world frame of the recordings has y down; the map's world frame has z up.
Eigen::Isometry3d WorldFromDataset() {
  Eigen::Isometry3d T_world_dataset = Eigen::Isometry3d::Identity();
  T_world_dataset.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return T_world_dataset;
}

fs::path ColorOf(const fs::path& folder, const std::string& stem) {
  for (const char* ending : {"color.png", "color.jpg", "color.jpeg"}) {
    fs::path file = folder / (stem + ending);
    std::error_code error;
    if (fs::exists(file, error)) return file;
  }
  return {};
}

absl::StatusOr<RecordedSequence> IndexSevenScenesSequence(const fs::path& folder) {
  const std::vector<fs::path> depth_files = ListFiles(folder, {".depth.png"});
  const auto camera = CameraOfSequence(folder, depth_files.front(), kSevenScenesCamera);
  if (!camera.ok()) return camera.status();
  RecordedSequence sequence;
  sequence.depth_sensor = v1::DEPTH_SENSOR_STRUCTURED_LIGHT;
  sequence.camera = *camera;
  sequence.T_world_dataset = WorldFromDataset();
  for (const fs::path& depth : depth_files) {
    const std::string stem = StemOf(depth);
    const fs::path pose_file = folder / (stem + "pose.txt");
    std::error_code error;
    RecordedFrame frame;
    frame.T_dataset_camera = ReadTransform(pose_file);
    const bool is_missing = !fs::exists(pose_file, error);
    const bool is_lost =
        frame.T_dataset_camera.ok() && !frame.T_dataset_camera->matrix().allFinite();
    if (is_missing || is_lost) {
      ++sequence.skipped_count;
      continue;
    }
    frame.time =
        Timestamp::FromNanoseconds(kFirstSevenScenesNs + kKinectPeriodNs * FrameNumberOf(stem));
    frame.depth = depth;
    frame.color = ColorOf(folder, stem);
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

}  // namespace

DatasetFormat SevenScenesFormat() {
  return {"seven-scenes",
          "files frame-000000.depth.png and so on",
          IsSevenScenesSequence,
          IndexSevenScenesSequence};
}

}  // namespace steadymap

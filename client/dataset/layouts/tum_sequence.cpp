#include "client/dataset/layouts/tum_sequence.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <absl/strings/numbers.h>
#include <absl/strings/str_split.h>

#include "client/dataset/files/camera_matrix.h"
#include "client/dataset/files/folder_listing.h"
#include "client/dataset/files/text_file.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;

// The published calibration for all cameras of the recordings.
constexpr PinholeCamera kTumCamera = {640, 480, 525.0, 525.0, 319.5, 239.5};
constexpr double kMetresPerUnit = 1.0 / 5000.0;
constexpr std::int64_t kMaxTimeGapNs = 20'000'000;

std::optional<Timestamp> TimeOf(double seconds) {
  if (!(seconds >= 0 && seconds <= kMaxRecordedSeconds)) return std::nullopt;
  return Timestamp::FromNanoseconds(std::llround(seconds * 1e6) * 1000);
}

// A value and its recording time.
template <typename Value>
struct Timed {
  Timestamp time;
  Value value;
};

template <typename Value>
void SortByTime(std::vector<Timed<Value>>* entries) {
  std::stable_sort(entries->begin(), entries->end(), [](const auto& a, const auto& b) {
    return a.time < b.time;
  });
}

// Returns the entry nearest in time, if the gap is at most `kMaxTimeGapNs`; otherwise null.
template <typename Value>
const Value* Nearest(const std::vector<Timed<Value>>& entries, Timestamp time) {
  const auto after = std::lower_bound(
      entries.begin(), entries.end(), time, [](const Timed<Value>& entry, Timestamp moment) {
        return entry.time < moment;
      });
  const Value* nearest = nullptr;
  std::int64_t gap_ns = kMaxTimeGapNs;
  for (auto entry : {after, after == entries.begin() ? after : after - 1}) {
    if (entry == entries.end()) continue;
    const std::int64_t distance_ns = std::abs((entry->time - time).nanoseconds());
    if (distance_ns > gap_ns) continue;
    gap_ns = distance_ns;
    nearest = &entry->value;
  }
  return nearest;
}

// Reads `rgb.txt` or `depth.txt`: lines `time file`, with the file relative to the folder.
absl::StatusOr<std::vector<Timed<fs::path>>> ReadImageList(const fs::path& list) {
  const absl::StatusOr<std::vector<TextLine>> lines = ReadTextLines(list);
  if (!lines.ok()) return lines.status();
  std::vector<Timed<fs::path>> images;
  for (const TextLine& line : *lines) {
    const std::vector<std::string> words =
        absl::StrSplit(line.text, absl::ByAnyChar(" \t"), absl::SkipEmpty());
    double seconds = 0.0;
    const std::optional<Timestamp> time =
        words.size() == 2 && absl::SimpleAtod(words[0], &seconds) ? TimeOf(seconds) : std::nullopt;
    if (!time) return MalformedLine(list, line, "\"time file\"");
    images.push_back({*time, list.parent_path() / words[1]});
  }
  SortByTime(&images);
  return images;
}

using TimedPoses = std::vector<Timed<absl::StatusOr<Eigen::Isometry3d>>>;

// Reads `groundtruth.txt`. Poses that are not finite are omitted.
absl::StatusOr<TimedPoses> ReadTimedPoses(const fs::path& file) {
  const absl::StatusOr<std::vector<TextLine>> lines = ReadTextLines(file);
  if (!lines.ok()) return lines.status();
  TimedPoses poses;
  for (const TextLine& line : *lines) {
    const std::optional<std::vector<double>> n = ParseNumbers(line.text);
    const std::optional<Timestamp> time = n && n->size() == 8 ? TimeOf((*n)[0]) : std::nullopt;
    if (!time) return MalformedLine(file, line, "\"time tx ty tz qx qy qz qw\"");
    if (!AreFinite(*n)) continue;
    poses.push_back({*time, ParsePose(file, line, std::span(*n).subspan<1, 7>())});
  }
  SortByTime(&poses);
  return poses;
}

bool IsTumSequence(const fs::path& folder) { return !FindEntry(folder, "depth.txt").empty(); }

absl::StatusOr<RecordedSequence> IndexTumSequence(const fs::path& folder) {
  const auto depth_images = ReadImageList(folder / "depth.txt");
  if (!depth_images.ok()) return depth_images.status();
  std::vector<Timed<fs::path>> color_images;
  if (const fs::path list = FindEntry(folder, "rgb.txt"); !list.empty()) {
    auto images = ReadImageList(list);
    if (!images.ok()) return images.status();
    color_images = *std::move(images);
  }
  const absl::StatusOr<TimedPoses> poses = ReadTimedPoses(folder / "groundtruth.txt");
  if (!poses.ok()) return poses.status();

  RecordedSequence sequence;
  sequence.metres_per_unit = kMetresPerUnit;
  sequence.depth_sensor = v1::DEPTH_SENSOR_STRUCTURED_LIGHT;
  sequence.camera = kTumCamera;
  if (!depth_images->empty()) {
    const auto camera = CameraOfSequence(folder, depth_images->front().value, kTumCamera);
    if (!camera.ok()) return camera.status();
    sequence.camera = *camera;
  }
  for (const Timed<fs::path>& depth : *depth_images) {
    const auto* pose = Nearest(*poses, depth.time);
    if (pose == nullptr) {
      ++sequence.skipped_count;
      continue;
    }
    RecordedFrame frame;
    frame.time = depth.time;
    frame.T_dataset_camera = *pose;
    frame.depth = depth.value;
    if (const fs::path* color = Nearest(color_images, depth.time)) frame.color = *color;
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

}  // namespace

DatasetFormat TumFormat() {
  return {"tum", "depth.txt, rgb.txt and groundtruth.txt", IsTumSequence, IndexTumSequence};
}

}  // namespace steadymap

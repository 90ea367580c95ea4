#include "client/dataset/layouts/co_fusion_sequence.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/numbers.h>

#include "client/dataset/files/depth_file.h"
#include "client/dataset/files/folder_listing.h"
#include "client/dataset/files/image_file.h"
#include "client/dataset/files/text_file.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;

// The recordings contain no times. Times are derived from frame numbers at the Kinect's frame rate,
// from an arbitrary fixed day.
constexpr std::int64_t kFirstCoFusionNs = 1'483'228'800'000'000'000;
constexpr std::int64_t kMaxFrameNumber = 100'000'000;

// Returns 12 for `Depth0012.exr`; none if the name contains no number.
std::optional<std::int64_t> NumberOf(const fs::path& file) {
  const std::string stem = file.stem().string();
  std::int64_t number = 0;
  const bool is_number =
      absl::SimpleAtoi(stem.substr(stem.find_last_not_of("0123456789") + 1), &number);
  return is_number && number <= kMaxFrameNumber ? std::make_optional(number) : std::nullopt;
}

using NumberedFiles = std::map<std::int64_t, fs::path>;

NumberedFiles ListNumbered(const fs::path& folder, std::string_view ending) {
  NumberedFiles files;
  if (folder.empty()) return files;
  for (const fs::path& file : ListFiles(folder, {ending})) {
    if (const std::optional<std::int64_t> number = NumberOf(file)) files.emplace(*number, file);
  }
  return files;
}

fs::path FileOf(const NumberedFiles& files, std::int64_t number) {
  const auto file = files.find(number);
  return file != files.end() ? file->second : fs::path();
}

// Returns the folder with noise-free depth if it exists, otherwise the one with noise.
fs::path DepthFolderOf(const fs::path& folder) {
  fs::path depth = FindEntry(folder, "depth_original");
  return !depth.empty() ? depth : FindEntry(folder, "depth_noise");
}

// Reads `calibration.txt`: a line `fx fy cx cy`, or `fx fy cx cy w h`. Without `w h`, the image
// size is that of `image`.
absl::StatusOr<PinholeCamera> ReadCamera(const fs::path& file, const fs::path& image) {
  const absl::StatusOr<std::vector<TextLine>> lines = ReadTextLines(file);
  if (!lines.ok()) return lines.status();
  constexpr std::string_view kExpected = "\"fx fy cx cy\" or \"fx fy cx cy w h\" of a camera";
  if (lines->empty()) return MalformedFile(file, kExpected, "no line");
  const TextLine& line = lines->front();
  const std::optional<std::vector<double>> n = ParseNumbers(line.text);
  if (!n || (n->size() != 4 && n->size() != 6)) return MalformedLine(file, line, kExpected);
  PinholeCamera camera = {0, 0, (*n)[0], (*n)[1], (*n)[2], (*n)[3]};
  if (n->size() == 6) {
    // NaN fails both comparisons. The cast below requires the range.
    const auto is_side = [](double side) { return side >= 1 && side <= kMaxImageSidePx; };
    if (!is_side((*n)[4]) || !is_side((*n)[5])) return MalformedLine(file, line, kExpected);
    camera.width_px = static_cast<int>((*n)[4]);
    camera.height_px = static_cast<int>((*n)[5]);
  } else {
    if (image.empty())
      return MalformedLine(file, line, "also w h, because there are no colour images");
    const absl::StatusOr<ImageFile> first = ReadImageFile(image);
    if (!first.ok()) return first.status();
    camera.width_px = first->size.width_px;
    camera.height_px = first->size.height_px;
  }
  return ValidateCamera(camera).ok() ? absl::StatusOr<PinholeCamera>(camera)
                                     : MalformedLine(file, line, kExpected);
}

using NumberedPoses = std::map<std::int64_t, absl::StatusOr<Eigen::Isometry3d>>;

// Reads `gt-cam-0.txt`. Poses that are not finite are omitted.
absl::StatusOr<NumberedPoses> ReadNumberedPoses(const fs::path& file) {
  const absl::StatusOr<std::vector<TextLine>> lines = ReadTextLines(file);
  if (!lines.ok()) return lines.status();
  NumberedPoses poses;
  for (const TextLine& line : *lines) {
    const std::optional<std::vector<double>> n = ParseNumbers(line.text);
    if (!n || n->size() != 8 || !((*n)[0] >= 0 && (*n)[0] <= kMaxFrameNumber) ||
        (*n)[0] != std::floor((*n)[0])) {
      return MalformedLine(file, line, "\"frame tx ty tz qx qy qz qw\"");
    }
    if (!AreFinite(*n)) continue;
    const auto number = static_cast<std::int64_t>((*n)[0]);
    if (!poses.emplace(number, ParsePose(file, line, std::span(*n).subspan<1, 7>())).second) {
      return MalformedLine(file, line, "each frame at most once");
    }
  }
  return poses;
}

bool IsCoFusionSequence(const fs::path& folder) {
  return !FindEntry(folder, "calibration.txt").empty() && !DepthFolderOf(folder).empty();
}

absl::StatusOr<RecordedSequence> IndexCoFusionSequence(const fs::path& folder) {
  const NumberedFiles depth = ListNumbered(DepthFolderOf(folder), ".exr");
  const NumberedFiles color = ListNumbered(FindEntry(folder, "colour"), ".png");
  const NumberedFiles masks = ListNumbered(FindEntry(folder, "mask_id"), ".png");
  const auto camera = ReadCamera(FindEntry(folder, "calibration.txt"),
                                 color.empty() ? fs::path() : color.begin()->second);
  if (!camera.ok()) return camera.status();
  const auto poses = ReadNumberedPoses(folder / "trajectories" / "gt-cam-0.txt");
  if (!poses.ok()) return poses.status();

  RecordedSequence sequence;
  sequence.camera = *camera;
  sequence.metres_per_unit = kMetresPerUnitOfFloatDepth;
  for (const auto& [number, file] : depth) {
    const auto pose = poses->find(number);
    if (pose == poses->end()) {
      ++sequence.skipped_count;
      continue;
    }
    RecordedFrame frame;
    frame.time = Timestamp::FromNanoseconds(kFirstCoFusionNs + kKinectPeriodNs * number);
    frame.T_dataset_camera = pose->second;
    frame.depth = file;
    frame.labels = FileOf(masks, number);
    frame.instances = frame.labels;
    frame.color = FileOf(color, number);
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

}  // namespace

DatasetFormat CoFusionFormat() {
  return {"co-fusion",
          "calibration.txt and a folder depth_original or depth_noise",
          IsCoFusionSequence,
          IndexCoFusionSequence,
          /*has_depth_unit=*/false};
}

}  // namespace steadymap

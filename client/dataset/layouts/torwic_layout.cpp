#include "client/dataset/layouts/torwic_layout.h"

#include <array>
#include <cstdio>
#include <optional>
#include <vector>

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include "client/dataset/files/text_file.h"

namespace steadymap {
namespace {

// Formats a double with enough digits to preserve every bit.
std::string Exact(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

std::string FormatPose(const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Quaterniond q(pose.linear());
  return absl::StrCat(Exact(t.x()), " ", Exact(t.y()), " ", Exact(t.z()), " ", Exact(q.x()), " ") +
         absl::StrCat(Exact(q.y()), " ", Exact(q.z()), " ", Exact(q.w()));
}

// Parses `w=640 h=360 fx=.. fy=.. cx=.. cy=..`, in any order, each key once.
std::optional<PinholeCamera> ParseCamera(const std::string& text) {
  constexpr std::array<const char*, 6> kKeys = {"w", "h", "fx", "fy", "cx", "cy"};
  std::array<std::optional<double>, 6> values;
  for (const absl::string_view word : absl::StrSplit(text, ' ', absl::SkipEmpty())) {
    const std::vector<absl::string_view> sides = absl::StrSplit(word, '=');
    if (sides.size() != 2) return std::nullopt;
    bool is_known = false;
    for (std::size_t i = 0; i < kKeys.size(); ++i) {
      double value = 0.0;
      if (sides[0] != kKeys[i] || values[i] || !absl::SimpleAtod(sides[1], &value)) continue;
      values[i] = value;
      is_known = true;
    }
    if (!is_known) return std::nullopt;
  }
  for (const std::optional<double>& value : values) {
    if (!value) return std::nullopt;
  }
  // NaN fails both comparisons. The casts below require the range.
  if (!(*values[0] >= 1 && *values[0] <= kMaxImageSidePx)) return std::nullopt;
  if (!(*values[1] >= 1 && *values[1] <= kMaxImageSidePx)) return std::nullopt;
  const PinholeCamera camera = {static_cast<int>(*values[0]),
                                static_cast<int>(*values[1]),
                                *values[2],
                                *values[3],
                                *values[4],
                                *values[5]};
  return ValidateCamera(camera).ok() ? std::make_optional(camera) : std::nullopt;
}

std::optional<Eigen::Isometry3d> ParseCameraPose(const std::string& text) {
  const std::optional<std::vector<double>> n = ParseNumbers(text);
  if (!n || n->size() != 7) return std::nullopt;
  const absl::StatusOr<Eigen::Isometry3d> pose =
      MakePose({(*n)[0], (*n)[1], (*n)[2]}, {(*n)[3], (*n)[4], (*n)[5], (*n)[6]});
  return pose.ok() ? std::make_optional(*pose) : std::nullopt;
}

}  // namespace

TorwicCalibration DefaultTorwicCalibration() {
  TorwicCalibration calibration;
  calibration.camera = {640, 360, 461.0956, 460.9182, 325.4782, 177.5766};
  // The published quaternion is rounded to three digits.
  calibration.T_base_camera.linear() =
      Eigen::Quaterniond(0.561, -0.431, 0.429, -0.562).normalized().toRotationMatrix();
  calibration.T_base_camera.translation() = Eigen::Vector3d(0.520, 0.032, 0.011);
  return calibration;
}

absl::StatusOr<TorwicCalibration> LoadTorwicCalibration(const std::filesystem::path& file) {
  const absl::StatusOr<std::vector<TextLine>> lines = ReadTextLines(file);
  if (!lines.ok()) return lines.status();
  if (lines->size() != 3) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.string(),
                     ": expected 3 lines (camera, T_base_camera, metres per unit), found ",
                     lines->size()));
  }
  const std::optional<PinholeCamera> camera = ParseCamera((*lines)[0].text);
  if (!camera) {
    return MalformedLine(file, (*lines)[0], "a camera \"w=.. h=.. fx=.. fy=.. cx=.. cy=..\"");
  }
  const std::optional<Eigen::Isometry3d> T_base_camera = ParseCameraPose((*lines)[1].text);
  if (!T_base_camera) {
    return MalformedLine(file, (*lines)[1], "T_base_camera \"tx ty tz qx qy qz qw\"");
  }
  const std::optional<std::vector<double>> scale = ParseNumbers((*lines)[2].text);
  if (!scale || scale->size() != 1 || !((*scale)[0] >= 1e-6 && (*scale)[0] <= 0.1)) {
    return MalformedLine(file, (*lines)[2], "metres per depth unit in [1e-6, 0.1]");
  }
  return TorwicCalibration{*camera, *T_base_camera, (*scale)[0]};
}

std::string FormatTorwicCalibration(const TorwicCalibration& calibration) {
  const PinholeCamera& camera = calibration.camera;
  return absl::StrCat("# camera; T_base_camera (tx ty tz qx qy qz qw); metres per depth unit\n",
                      "w=",
                      camera.width_px,
                      " h=",
                      camera.height_px,
                      " fx=",
                      Exact(camera.fx)) +
         absl::StrCat(" fy=", Exact(camera.fy), " cx=", Exact(camera.cx), " cy=") +
         absl::StrCat(Exact(camera.cy), "\n", FormatPose(calibration.T_base_camera), "\n") +
         absl::StrCat(Exact(calibration.metres_per_unit), "\n");
}

std::string FormatTorwicPose(std::size_t id, Timestamp time, const Eigen::Isometry3d& T_map_base) {
  return absl::StrCat(id,
                      " ",
                      time.nanoseconds() / kNanosecondsPerSecond,
                      " ",
                      time.nanoseconds() % kNanosecondsPerSecond,
                      " ",
                      FormatPose(T_map_base));
}

}  // namespace steadymap

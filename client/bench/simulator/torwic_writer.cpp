#include "client/bench/simulator/torwic_writer.h"

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "client/dataset/layouts/torwic_layout.h"
#include "core/frame/image_codec.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;

constexpr char kDepthFolder[] = "Depth";
constexpr char kLabelFolder[] = "Segmentation";
constexpr char kInstanceFolder[] = "Instances";
constexpr char kColorFolder[] = "RGB";

absl::Status WriteFile(const fs::path& file, std::string_view content) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  if (stream) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(file.string(), ": cannot be written"));
}

// Writes one sequence, frame by frame.
class SequenceWriter {
 public:
  SequenceWriter(fs::path folder, const PinholeCamera& camera) : folder_(std::move(folder)) {
    calibration_ = DefaultTorwicCalibration();
    calibration_.camera = camera;
  }

  absl::Status Write(const Frame& frame) {
    const std::string name = absl::StrFormat("%04d.png", count_);
    absl::Status status =
        WriteImage(kDepthFolder, name, EncodePixels(frame.depth.units, PixelEncoding::kPng, true));
    if (status.ok()) {
      status = WriteImage(kLabelFolder, name, EncodePixels(frame.labels, PixelEncoding::kPng));
    }
    if (status.ok() && !frame.instances.empty()) {
      status = WriteImage(
          kInstanceFolder, name, EncodePixels(frame.instances, PixelEncoding::kPng, true));
    }
    if (status.ok() && !frame.color.empty()) {
      status = WriteImage(kColorFolder, name, EncodeColorPng(frame.color));
    }
    const Eigen::Isometry3d T_map_base =
        frame.T_world_camera * calibration_.T_base_camera.inverse();
    poses_ += FormatTorwicPose(count_++, frame.capture_time, T_map_base) + "\n";
    return status;
  }

  absl::Status Finish() const {
    if (absl::Status status = WriteFile(folder_ / "poses.txt", poses_); !status.ok()) return status;
    return WriteFile(folder_ / "calibration.txt", FormatTorwicCalibration(calibration_));
  }

 private:
  absl::Status WriteImage(const char* kind, const std::string& name, std::string_view content) {
    const fs::path folder = folder_ / kind;
    if (count_ == 0) {
      std::error_code error;
      fs::create_directories(folder, error);
      if (error) {
        return absl::UnavailableError(
            absl::StrCat(folder.string(), ": cannot be created: ", error.message()));
      }
    }
    return WriteFile(folder / name, content);
  }

  fs::path folder_;
  TorwicCalibration calibration_;
  std::string poses_;
  std::size_t count_ = 0;
};

}  // namespace

absl::Status WriteTorwicFolder(const Route& route,
                               const std::filesystem::path& directory,
                               const SimulationOptions& options,
                               const std::function<void(std::size_t)>& on_frame) {
  Simulation simulation(route, options);
  std::size_t index = 0;
  for (std::size_t sequence = 0; sequence < route.sequences.size(); ++sequence) {
    const std::string name =
        absl::StrFormat("%02d-%s", sequence + 1, route.sequences[sequence].name);
    SequenceWriter writer(directory / name, route.camera);
    for (; index < simulation.frame_count() && simulation.SequenceOf(index) == sequence; ++index) {
      if (absl::Status status = writer.Write(simulation.Render(index)); !status.ok()) return status;
      if (on_frame) on_frame(index + 1);
    }
    if (absl::Status status = writer.Finish(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace steadymap

#include "proto/convert_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/frame/image_codec.h"
#include "core/types/error.h"
#include "core/types/parallel.h"
#include "proto/convert_geometry.h"

namespace steadymap {
namespace {

std::optional<PixelEncoding> DepthEncodingOf(v1::DepthEncoding encoding) {
  switch (encoding) {
    case v1::DEPTH_ENCODING_RAW_UINT16:
      return PixelEncoding::kRawUint16;
    case v1::DEPTH_ENCODING_PNG_UINT16:
      return PixelEncoding::kPng;
    case v1::DEPTH_ENCODING_ZSTD_UINT16:
      return PixelEncoding::kZstdUint16;
    default:
      return std::nullopt;
  }
}

std::optional<PixelEncoding> LabelEncodingOf(v1::LabelEncoding encoding) {
  switch (encoding) {
    case v1::LABEL_ENCODING_RAW_UINT8:
      return PixelEncoding::kRawUint8;
    case v1::LABEL_ENCODING_RAW_UINT16:
      return PixelEncoding::kRawUint16;
    case v1::LABEL_ENCODING_PNG:
      return PixelEncoding::kPng;
    case v1::LABEL_ENCODING_ZSTD_UINT8:
      return PixelEncoding::kZstdUint8;
    case v1::LABEL_ENCODING_ZSTD_UINT16:
      return PixelEncoding::kZstdUint16;
    default:
      return std::nullopt;
  }
}

std::optional<ColorEncoding> ColorEncodingOf(v1::ColorEncoding encoding) {
  switch (encoding) {
    case v1::COLOR_ENCODING_JPEG:
      return ColorEncoding::kJpeg;
    case v1::COLOR_ENCODING_PNG:
      return ColorEncoding::kPng;
    default:
      return std::nullopt;
  }
}

absl::Status UnknownEncoding(std::string_view reason, int encoding) {
  return InvalidField(
      reason, "encoding", absl::StrCat("the encoding must be one that is known, got ", encoding));
}

absl::StatusOr<Image<std::uint16_t>> Decode(const v1::DepthImage& message,
                                            const PinholeCamera& camera) {
  const std::optional<PixelEncoding> encoding = DepthEncodingOf(message.encoding());
  if (!encoding) return UnknownEncoding(reason::kBadDepthEncoding, message.encoding());
  return DecodeDepth(message.data(), *encoding, camera.width_px, camera.height_px);
}

absl::StatusOr<Image<std::uint16_t>> Decode(const v1::LabelImage& message,
                                            const PinholeCamera& camera) {
  const std::optional<PixelEncoding> encoding = LabelEncodingOf(message.encoding());
  if (!encoding) return UnknownEncoding(reason::kBadImageEncoding, message.encoding());
  return DecodePixels(message.data(), *encoding, camera.width_px, camera.height_px);
}

absl::StatusOr<Image<Rgb>> Decode(const v1::ColorImage& message, const PinholeCamera& camera) {
  const std::optional<ColorEncoding> encoding = ColorEncodingOf(message.encoding());
  if (!encoding) return UnknownEncoding(reason::kBadImageEncoding, message.encoding());
  return DecodeColor(message.data(), *encoding, camera.width_px, camera.height_px);
}

/// Decodes `message` to `image`; errors name `field`.
template <typename Message, typename Pixel>
absl::Status DecodeInto(const Message& message,
                        const char* field,
                        const PinholeCamera& camera,
                        Image<Pixel>* image) {
  absl::StatusOr<Image<Pixel>> decoded = Decode(message, camera);
  if (!decoded.ok()) return WithFieldPrefix(decoded.status(), field);
  *image = std::move(*decoded);
  return absl::OkStatus();
}

/// Images with at least this many pixels are decoded in parallel: decoding takes about 100 us
/// there.
constexpr int kMinParallelPixels = 1 << 16;

/// Decodes all images of a frame; returns the error of the first invalid image.
absl::Status DecodeImages(const v1::Frame& message, Frame* frame) {
  const PinholeCamera& camera = frame->camera;
  const std::array<std::function<absl::Status()>, 4> images = {
      [&] { return DecodeInto(message.depth(), "depth", camera, &frame->depth.units); },
      [&] {
        return message.has_labels() ? DecodeInto(message.labels(), "labels", camera, &frame->labels)
                                    : absl::OkStatus();
      },
      [&] {
        return message.has_instances()
                   ? DecodeInto(message.instances(), "instances", camera, &frame->instances)
                   : absl::OkStatus();
      },
      [&] {
        return message.has_color() ? DecodeInto(message.color(), "color", camera, &frame->color)
                                   : absl::OkStatus();
      }};
  std::array<absl::Status, 4> results;
  const bool is_small = camera.width_px * camera.height_px < kMinParallelPixels;
  ParallelFor(images.size(), is_small ? images.size() : 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) results[i] = images[i]();
  });
  for (const absl::Status& result : results) {
    if (!result.ok()) return result;
  }
  return absl::OkStatus();
}

/// Returns nothing for an unknown value.
std::optional<DepthSensorKind> SensorFromProto(v1::DepthSensor sensor) {
  switch (sensor) {
    case v1::DEPTH_SENSOR_UNSPECIFIED:
      return DepthSensorKind::kUnknown;
    case v1::DEPTH_SENSOR_STRUCTURED_LIGHT:
      return DepthSensorKind::kStructuredLight;
    case v1::DEPTH_SENSOR_STEREO:
      return DepthSensorKind::kStereo;
    case v1::DEPTH_SENSOR_TIME_OF_FLIGHT:
      return DepthSensorKind::kTimeOfFlight;
    case v1::DEPTH_SENSOR_LIDAR:
      return DepthSensorKind::kLidar;
    default:
      return std::nullopt;
  }
}

/// Reads capture time, intrinsics, pose, depth unit and depth sensor.
absl::Status ReadHeader(const v1::Frame& message, Frame* frame) {
  if (!message.has_capture_time()) {
    return InvalidField(
        reason::kBadTimestamp, "capture_time", "a frame needs its capture_time, it is absent");
  }
  const absl::StatusOr<Timestamp> capture_time = FromProto(message.capture_time());
  if (!capture_time.ok()) return WithFieldPrefix(capture_time.status(), "capture_time");
  const absl::StatusOr<PinholeCamera> camera = FromProto(message.intrinsics());
  if (!camera.ok()) return WithFieldPrefix(camera.status(), "intrinsics");
  const absl::StatusOr<Eigen::Isometry3d> pose = FromProto(message.world_from_camera());
  if (!pose.ok()) return WithFieldPrefix(pose.status(), "world_from_camera");
  frame->capture_time = *capture_time;
  frame->camera = *camera;
  frame->T_world_camera = *pose;
  frame->depth.metres_per_unit = message.depth().metres_per_unit();
  const std::optional<DepthSensorKind> sensor = SensorFromProto(message.depth().sensor());
  if (!sensor.has_value()) {
    return InvalidField(reason::kBadValue,
                        "depth.sensor",
                        absl::StrCat("the depth sensor must be one that is known, got ",
                                     static_cast<int>(message.depth().sensor())));
  }
  frame->depth.sensor = *sensor;
  return absl::OkStatus();
}

/// Checks the fields that the log stores and no update policy uses yet.
absl::Status CheckAnnotations(const v1::Frame& message) {
  if (!v1::ClockDomain_IsValid(message.clock_domain())) {
    return InvalidField(reason::kBadValue,
                        "clock_domain",
                        absl::StrCat("the clock domain must be one that is known, got ",
                                     static_cast<int>(message.clock_domain())));
  }
  if (!message.has_pose_covariance()) return absl::OkStatus();
  constexpr int kSide = 6;
  constexpr int kNumbers = kSide * (kSide + 1) / 2;
  const auto& numbers = message.pose_covariance().upper_triangle();
  bool is_possible =
      numbers.size() == kNumbers && std::all_of(numbers.begin(), numbers.end(), [](double number) {
        return std::isfinite(number);
      });
  int diagonal = 0;
  for (int row = 0; row < kSide && is_possible; ++row) {
    is_possible = numbers[diagonal] >= 0.0;
    diagonal += kSide - row;
  }
  if (is_possible) return absl::OkStatus();
  return InvalidField(reason::kBadValue,
                      "pose_covariance.upper_triangle",
                      absl::StrCat("upper_triangle must hold ",
                                   kNumbers,
                                   " finite numbers, those of the diagonal not below 0"));
}

}  // namespace

absl::StatusOr<Frame> FromProto(const v1::Frame& message,
                                const SensorName& source,
                                const KnownLabels& labels) {
  Frame frame;
  frame.source = source;
  absl::Status status = ReadHeader(message, &frame);
  if (status.ok()) status = CheckAnnotations(message);
  if (status.ok()) status = DecodeImages(message, &frame);
  if (status.ok()) status = ValidateFrame(frame, labels);
  // ValidateFrame accepts every pose that MakePose returns, so all field paths are proto paths.
  if (!status.ok()) return status;
  return frame;
}

std::size_t DecodedBytes(const v1::Frame& message) {
  const auto side = [](std::uint32_t side_px) {
    return std::min<std::size_t>(side_px, static_cast<std::size_t>(kMaxImageSidePx));
  };
  std::size_t bytes_per_pixel = sizeof(std::uint16_t);
  if (message.has_labels()) bytes_per_pixel += sizeof(std::uint16_t);
  if (message.has_instances()) bytes_per_pixel += sizeof(std::uint16_t);
  if (message.has_color()) bytes_per_pixel += sizeof(Rgb);
  const v1::CameraIntrinsics& camera = message.intrinsics();
  return side(camera.width_px()) * side(camera.height_px()) * bytes_per_pixel;
}

absl::StatusOr<PinholeCamera> FromProto(const v1::CameraIntrinsics& message) {
  // The limit plus one represents all larger values, which may not fit an int.
  const auto side = [](std::uint32_t side_px) {
    return static_cast<int>(std::min(side_px, static_cast<std::uint32_t>(kMaxImageSidePx) + 1));
  };
  const PinholeCamera camera{side(message.width_px()),
                             side(message.height_px()),
                             message.fx(),
                             message.fy(),
                             message.cx(),
                             message.cy()};
  if (absl::Status status = ValidateCamera(camera); !status.ok()) return status;
  return camera;
}

v1::CameraIntrinsics ToProto(const PinholeCamera& camera) {
  v1::CameraIntrinsics message;
  message.set_width_px(static_cast<std::uint32_t>(camera.width_px));
  message.set_height_px(static_cast<std::uint32_t>(camera.height_px));
  message.set_fx(camera.fx);
  message.set_fy(camera.fy);
  message.set_cx(camera.cx);
  message.set_cy(camera.cy);
  return message;
}

}  // namespace steadymap

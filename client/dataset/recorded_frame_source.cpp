#include "client/dataset/recorded_frame_source.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "client/dataset/files/depth_file.h"
#include "client/dataset/files/image_file.h"
#include "client/dataset/frame_message.h"
#include "client/dataset/layouts/segment_classes.h"
#include "core/frame/image_codec.h"

namespace steadymap {
namespace {

// Pause between the end of a sequence and the start of the next one, if its times were shifted.
constexpr std::int64_t kPauseNs = 1'000'000'000;

// Shifts the times of each sequence that starts before the end of the previous sequence.
void KeepTimesIncreasing(std::vector<RecordedSequence>* sequences) {
  std::int64_t end_ns = std::numeric_limits<std::int64_t>::min();
  for (RecordedSequence& sequence : *sequences) {
    if (sequence.frames.empty()) continue;
    const auto [first, last] = std::minmax_element(
        sequence.frames.begin(),
        sequence.frames.end(),
        [](const RecordedFrame& a, const RecordedFrame& b) { return a.time < b.time; });
    const std::int64_t first_ns = first->time.nanoseconds();
    const std::int64_t shift_ns = first_ns > end_ns ? 0 : end_ns + kPauseNs - first_ns;
    end_ns = last->time.nanoseconds() + shift_ns;
    for (RecordedFrame& frame : sequence.frames) {
      frame.time = Timestamp::FromNanoseconds(frame.time.nanoseconds() + shift_ns);
    }
  }
}

bool FitsIn8Bits(const Image<std::uint16_t>& image) {
  return std::all_of(image.data(), image.data() + image.size(), [](std::uint16_t pixel) {
    return pixel <= std::numeric_limits<std::uint8_t>::max();
  });
}

// Packs a label image. `segment_classes` may be empty.
absl::Status PackLabels(const std::filesystem::path& file,
                        const std::filesystem::path& segment_classes,
                        const PinholeCamera& camera,
                        const LabelMap& label_map,
                        v1::LabelImage* message) {
  absl::StatusOr<ImageFile> image = ReadPngFile(file, camera);
  if (!image.ok()) return image.status();
  if (label_map.is_identity() && segment_classes.empty()) {
    message->set_encoding(v1::LABEL_ENCODING_PNG);
    message->set_data(std::move(image->data));
    return absl::OkStatus();
  }
  absl::StatusOr<Image<std::uint16_t>> labels =
      DecodePixels(image->data, PixelEncoding::kPng, camera.width_px, camera.height_px);
  if (!labels.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.string(), ": expected a label image: ", labels.status().message()));
  }
  if (!segment_classes.empty()) {
    const absl::StatusOr<SegmentClasses> classes = SegmentClasses::Load(segment_classes);
    if (!classes.ok()) return classes.status();
    classes->Apply(&*labels);
  }
  label_map.Apply(&*labels);
  const bool is_narrow = FitsIn8Bits(*labels);
  message->set_encoding(is_narrow ? v1::LABEL_ENCODING_ZSTD_UINT8 : v1::LABEL_ENCODING_ZSTD_UINT16);
  message->set_data(
      EncodePixels(*labels, is_narrow ? PixelEncoding::kZstdUint8 : PixelEncoding::kZstdUint16));
  return absl::OkStatus();
}

// Only every 13th pixel is used, which is enough for a median. The step is prime, so that the
// pixels are not from a few columns only.
constexpr std::size_t kDepthPixelStep = 13;

// Appends the depth of a sample of valid pixels, metres; false if the depth image cannot be read.
bool AppendDepth(const RecordedSequence& sequence,
                 const RecordedFrame& frame,
                 std::vector<float>* depth_m) {
  v1::DepthImage packed;
  if (!PackDepthFile(frame.depth, sequence.camera, sequence.metres_per_unit, &packed).ok()) {
    return false;
  }
  const bool is_png = packed.encoding() == v1::DEPTH_ENCODING_PNG_UINT16;
  const absl::StatusOr<Image<std::uint16_t>> units =
      DecodeDepth(packed.data(),
                  is_png ? PixelEncoding::kPng : PixelEncoding::kZstdUint16,
                  sequence.camera.width_px,
                  sequence.camera.height_px);
  if (!units.ok()) return false;
  for (std::size_t i = 0; i < units->size(); i += kDepthPixelStep) {
    const std::uint16_t unit = units->data()[i];
    if (unit == kNoDepth || unit == kInvalidDepth) continue;
    depth_m->push_back(static_cast<float>(unit * sequence.metres_per_unit));
  }
  return true;
}

}  // namespace

RecordedFrameSource::RecordedFrameSource(std::vector<RecordedSequence> sequences,
                                         PlaybackOptions options)
    : sequences_(std::move(sequences)), options_(std::move(options)) {
  assert(options_.stride >= 1);
  KeepTimesIncreasing(&sequences_);
  for (std::size_t sequence = 0; sequence < sequences_.size(); ++sequence) {
    skipped_count_ += sequences_[sequence].skipped_count;
    const std::size_t count = sequences_[sequence].frames.size();
    for (std::size_t i = 0; i < count; i += options_.stride) places_.push_back({sequence, i});
  }
}

RecordingSample RecordedFrameSource::Sample(std::size_t frame_count) const {
  RecordingSample sample;
  std::vector<float> depth_m;
  frame_count = std::min(frame_count, places_.size());
  for (std::size_t i = 0; i < frame_count; ++i) {
    const Place place =
        places_[i * (places_.size() - 1) / std::max<std::size_t>(frame_count - 1, 1)];
    const RecordedSequence& sequence = sequences_[place.sequence];
    if (!AppendDepth(sequence, sequence.frames[place.frame], &depth_m)) continue;
    if (sample.frame_count++ == 0) sample.metres_per_unit = sequence.metres_per_unit;
  }
  if (!places_.empty()) {
    sample.first_time = sequences_[places_[0].sequence].frames[places_[0].frame].time;
  }
  if (!depth_m.empty()) {
    const auto middle = depth_m.begin() + static_cast<std::ptrdiff_t>(depth_m.size() / 2);
    std::nth_element(depth_m.begin(), middle, depth_m.end());
    sample.median_depth_m = static_cast<double>(*middle);
  }
  return sample;
}

absl::StatusOr<std::optional<v1::Frame>> RecordedFrameSource::Next() {
  if (next_place_ == places_.size()) return std::optional<v1::Frame>();
  absl::StatusOr<v1::Frame> frame = Read(next_place_++);
  if (!frame.ok()) return frame.status();
  return std::optional<v1::Frame>(*std::move(frame));
}

absl::StatusOr<v1::Frame> RecordedFrameSource::Read(std::size_t index) {
  if (index >= places_.size()) return NoFrameAt(index, places_.size());
  const Place place = places_[index];
  const RecordedSequence& sequence = sequences_[place.sequence];
  return Load(sequence, sequence.frames[place.frame]);
}

absl::StatusOr<v1::Frame> RecordedFrameSource::Load(const RecordedSequence& sequence,
                                                    const RecordedFrame& frame) const {
  if (!frame.T_dataset_camera.ok()) return frame.T_dataset_camera.status();
  v1::Frame message;
  const Eigen::Isometry3d T_world_dataset =
      options_.T_world_dataset.value_or(sequence.T_world_dataset);
  FillFrameMessage(
      frame.time, sequence.camera, T_world_dataset * *frame.T_dataset_camera, &message);

  const absl::Status packed = PackDepthFile(
      frame.depth, sequence.camera, sequence.metres_per_unit, message.mutable_depth());
  if (!packed.ok()) return packed;
  message.mutable_depth()->set_sensor(sequence.depth_sensor);

  if (!frame.labels.empty()) {
    const absl::Status status = PackLabels(frame.labels,
                                           frame.segment_classes,
                                           sequence.camera,
                                           options_.label_map,
                                           message.mutable_labels());
    if (!status.ok()) return status;
  }
  if (!frame.instances.empty()) {
    const absl::Status status =
        PackLabels(frame.instances, {}, sequence.camera, LabelMap(), message.mutable_instances());
    if (!status.ok()) return status;
  }
  if (options_.include_color && !frame.color.empty()) {
    absl::StatusOr<ImageFile> color = ReadImageFile(frame.color, sequence.camera);
    if (!color.ok()) return color.status();
    message.mutable_color()->set_encoding(color->is_png ? v1::COLOR_ENCODING_PNG
                                                        : v1::COLOR_ENCODING_JPEG);
    message.mutable_color()->set_data(std::move(color->data));
  }
  return message;
}

}  // namespace steadymap

#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <absl/status/statusor.h>

#include "client/dataset/dataset.h"
#include "client/dataset/layouts/label_map.h"
#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// Options for the conversion of indexed sequences to frames.
struct PlaybackOptions {
  std::size_t stride = 1;                            ///< At least 1.
  LabelMap label_map;                                ///< Applied to every label image.
  std::optional<Eigen::Isometry3d> T_world_dataset;  ///< Replaces the transform of each sequence.
  bool include_color = true;
};

/// Plays indexed sequences of any format one after the other. Image files are copied unchanged,
/// except that changed labels and depth in metres are re-encoded.
class RecordedFrameSource : public DatasetSource {
 public:
  RecordedFrameSource(std::vector<RecordedSequence> sequences, PlaybackOptions options);

  std::size_t frame_count() const override { return places_.size(); }

  std::size_t skipped_count() const override { return skipped_count_; }

  RecordingSample Sample(std::size_t frame_count) const override;

  absl::StatusOr<std::optional<v1::Frame>> Next() override;

  absl::StatusOr<v1::Frame> Read(std::size_t index) override;

 private:
  struct Place {
    std::size_t sequence = 0;
    std::size_t frame = 0;
  };

  absl::StatusOr<v1::Frame> Load(const RecordedSequence& sequence,
                                 const RecordedFrame& frame) const;

  std::vector<RecordedSequence> sequences_;
  PlaybackOptions options_;
  std::vector<Place> places_;  ///< The played frames, in order.
  std::size_t next_place_ = 0;
  std::size_t skipped_count_ = 0;
};

}  // namespace steadymap

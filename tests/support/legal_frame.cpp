#include "tests/support/legal_frame.h"

#include <algorithm>
#include <array>
#include <random>

#include <absl/strings/str_cat.h>

#include "tests/support/all_policies.h"

namespace steadymap {
namespace {

enum class DepthContent { kWall, kSlope, kComb, kBlocks, kNoise };
enum class LabelContent { kNone, kNoise, kOneThing, kThingAPixel, kThingABlock };

constexpr std::array kPolicyNames{
    "static", "voxel_change", "submap_change", "tracking", "pocd", "pocd_paper"};
constexpr std::array kVoxelSizesM{0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.2, 1.0};
constexpr std::array kTruncationVoxels{2.0, 3.0, 16.0};
constexpr std::array kMaxDepthsM{0.5, 3.0, 10.0, 30.0, 100.0};
constexpr std::array kSidesPx{64, 320, 640, 1280, 4096};
constexpr std::array kFocalLengthSides{0.05, 0.5, 1.0, 10.0};
constexpr std::array kPositionsM{0.0, 9'000.0};
constexpr std::array kDepthContents{DepthContent::kWall,
                                    DepthContent::kSlope,
                                    DepthContent::kComb,
                                    DepthContent::kBlocks,
                                    DepthContent::kNoise};
constexpr std::array kLabelContents{LabelContent::kNone,
                                    LabelContent::kNoise,
                                    LabelContent::kOneThing,
                                    LabelContent::kThingAPixel,
                                    LabelContent::kThingABlock};

// Largest depth of a map, in voxels.
constexpr double kMaxDepthVoxels = 4000.0;

constexpr double kLargestUnits = 65'000.0;

class FrameMaker {
 public:
  FrameMaker(std::uint64_t seed, int max_side_px) : random_(seed), max_side_px_(max_side_px) {}

  LegalFrame Make() {
    MakeConfig();
    MakeCamera();
    MakeDepth();
    MakeLabels();
    return made_;
  }

 private:
  template <typename Choices>
  auto Choose(const Choices& choices) {
    return choices[random_() % std::size(choices)];
  }

  void MakeConfig() {
    MapConfig& config = made_.config;
    config.policy = Choose(testing::kAllPolicies);
    config.voxel_size_m = Choose(kVoxelSizesM);
    config.truncation_m = Choose(kTruncationVoxels) * config.voxel_size_m;
    config.max_depth_m = std::min(Choose(kMaxDepthsM), kMaxDepthVoxels * config.voxel_size_m);
    absl::StrAppend(&made_.description,
                    kPolicyNames[static_cast<std::size_t>(config.policy)],
                    ", voxels ",
                    config.voxel_size_m,
                    " m, truncation ",
                    config.truncation_m,
                    " m, depth ",
                    config.max_depth_m,
                    " m");
  }

  void MakeCamera() {
    Frame& frame = made_.frame;
    const int width_px = std::min(Choose(kSidesPx), max_side_px_);
    const int height_px = width_px == 4096 ? 4096 : std::max(1, width_px * 3 / 4);
    const double focal_length_px = Choose(kFocalLengthSides) * width_px;
    frame.source = {"robot", "camera"};
    frame.camera = {
        width_px, height_px, focal_length_px, focal_length_px, width_px / 2.0, height_px / 2.0};
    frame.T_world_camera.translation().setConstant(Choose(kPositionsM) / 2.0);
    absl::StrAppend(
        &made_.description, ", ", width_px, " x ", height_px, " px, f ", focal_length_px);
  }

  /// Returns the depth as a share of the largest.
  double DepthShare(DepthContent content, int u, int v) {
    const PinholeCamera& camera = made_.frame.camera;
    switch (content) {
      case DepthContent::kWall:
        return wall_share_;
      case DepthContent::kSlope:
        return (u + 1.0) / camera.width_px;
      case DepthContent::kComb:
        return u % 2 == 0 ? 0.2 : 0.2 + 0.8 * (v + 1.0) / camera.height_px;
      case DepthContent::kBlocks:
        return ((u / 8 + v / 8) * 37 % 100 + 1) / 100.0;
      default:
        return static_cast<double>(random_() % 1000 + 1) / 1000.0;
    }
  }

  void MakeDepth() {
    Frame& frame = made_.frame;
    const PinholeCamera& camera = frame.camera;
    const DepthContent content = Choose(kDepthContents);
    wall_share_ = Choose(std::array{0.05, 0.3, 1.0});
    frame.depth.units = Image<std::uint16_t>(camera.width_px, camera.height_px);
    frame.depth.metres_per_unit = made_.config.max_depth_m / kLargestUnits;
    for (int v = 0; v < camera.height_px; ++v) {
      for (int u = 0; u < camera.width_px; ++u) {
        frame.depth.units.At(u, v) =
            static_cast<std::uint16_t>(kLargestUnits * DepthShare(content, u, v));
      }
    }
    constexpr std::array kNames{"wall", "slope", "comb", "blocks", "noise"};
    absl::StrAppend(&made_.description, ", ", kNames[static_cast<std::size_t>(content)]);
    if (content == DepthContent::kWall) absl::StrAppend(&made_.description, " at ", wall_share_);
  }

  void MakeLabels() {
    Frame& frame = made_.frame;
    const LabelContent content = Choose(kLabelContents);
    constexpr std::array kNames{
        "no labels", "labels at random", "one thing", "a thing a pixel", "a thing a block"};
    absl::StrAppend(&made_.description, ", ", kNames[static_cast<std::size_t>(content)]);
    if (content == LabelContent::kNone) return;
    const auto limit = static_cast<std::uint64_t>(made_.config.label_limit());
    // Goods: a movable object.
    const auto thing = static_cast<std::uint16_t>(7);
    frame.labels = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px, thing);
    if (content == LabelContent::kNoise) {
      for (std::size_t i = 0; i < frame.labels.size(); ++i) {
        frame.labels.data()[i] = static_cast<std::uint16_t>(random_() % limit);
      }
    }
    if (content == LabelContent::kThingAPixel) MakeInstances(1);
    if (content == LabelContent::kThingABlock) {
      const int side_px = Choose(std::array{8, 16, 32});
      absl::StrAppend(&made_.description, " of ", side_px, " px");
      MakeInstances(side_px);
    }
  }

  /// Labels squares of `side_px` as separate instances.
  void MakeInstances(int side_px) {
    Frame& frame = made_.frame;
    const PinholeCamera& camera = frame.camera;
    frame.instances = Image<std::uint16_t>(camera.width_px, camera.height_px);
    const int blocks_wide = camera.width_px / side_px + 1;
    for (int v = 0; v < camera.height_px; ++v) {
      for (int u = 0; u < camera.width_px; ++u) {
        const int block = v / side_px * blocks_wide + u / side_px;
        frame.instances.At(u, v) = static_cast<std::uint16_t>(block % 65'535 + 1);
      }
    }
  }

  std::mt19937_64 random_;
  const int max_side_px_;
  double wall_share_ = 0.0;
  LegalFrame made_;
};

}  // namespace

LegalFrame RandomLegalFrame(std::uint64_t seed, int max_side_px) {
  return FrameMaker(seed, max_side_px).Make();
}

}  // namespace steadymap

// Boxes in front of a wall, seen by a camera at the origin that looks along x.

#include "core/association/frame_segments.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::SceneBody;

SceneBody DistantWall() { return Body(kWallClass, {2.6, -4.0, -4.0}, {2.8, 4.0, 4.0}); }

SceneBody BoxAt(double front_m, double left_m, double right_m) {
  return Body(kGoodsClass, {front_m, left_m, -0.3}, {front_m + 0.3, right_m, 0.3});
}

class FrameSegmentsTest : public ::testing::Test {
 protected:
  FrameSegmentsTest() : cloud_(MapConfig()) {}

  void Look(const Frame& frame) {
    cloud_.Compute(frame);
    samples_.Compute(cloud_);
    uses_.assign(samples_.size(), SampleUse::kSegment);
  }

  std::vector<FrameSegment> FindOf(std::uint16_t label) const {
    std::vector<FrameSegment> segments =
        FindFrameSegments(cloud_, samples_, uses_, ContinuityParameters());
    std::erase_if(segments, [label](const auto& segment) { return segment.label != label; });
    return segments;
  }

  SemanticCloud cloud_;
  SampleGrid samples_;
  std::vector<SampleUse> uses_;
};

TEST_F(FrameSegmentsTest, OneThingIsOneSegmentOfItsArea) {
  Look(RenderScene({DistantWall(), BoxAt(1.5, -0.25, 0.25)}, {}));
  const std::vector<FrameSegment> boxes = FindOf(kGoodsClass);
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_NEAR(boxes.front().area_m2, 0.5 * 0.6, 0.05);
  EXPECT_TRUE(std::is_sorted(boxes.front().samples.begin(), boxes.front().samples.end()));
}

TEST_F(FrameSegmentsTest, ThingsOfOneClassWithAGapAreTwo) {
  Look(RenderScene({DistantWall(), BoxAt(1.5, -0.5, -0.05), BoxAt(1.5, 0.05, 0.5)}, {}));
  EXPECT_EQ(FindOf(kGoodsClass).size(), 2U);
}

TEST_F(FrameSegmentsTest, BoxesInLineThatAreSeenAtAFlatAngleAreNotConnected) {
  // The front sides of both boxes are in one plane, along which the camera looks almost.
  const SceneBody near = Body(kGoodsClass, {1.0, 0.3, -0.3}, {1.5, 0.6, 0.3});
  const SceneBody far = Body(kGoodsClass, {1.6, 0.3, -0.3}, {2.1, 0.6, 0.3});
  Look(RenderScene({DistantWall(), near, far}, {}));
  for (const FrameSegment& segment : FindOf(kGoodsClass)) {
    bool has_near = false;
    bool has_far = false;
    for (const std::size_t index : segment.samples) {
      (samples_[index].position_world.x() < 1.55F ? has_near : has_far) = true;
    }
    EXPECT_FALSE(has_near && has_far);
  }
}

TEST_F(FrameSegmentsTest, AThingBehindAnotherOneOfItsClassIsASecondSegment) {
  Look(RenderScene({DistantWall(), BoxAt(1.2, -0.3, 0.0), BoxAt(1.9, -0.2, 0.5)}, {}));
  EXPECT_EQ(FindOf(kGoodsClass).size(), 2U);
}

TEST_F(FrameSegmentsTest, InstancesDivideWhatTouches) {
  Frame frame = RenderScene({DistantWall(), BoxAt(1.5, -0.4, 0.4)}, {});
  frame.instances = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px);
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      if (frame.labels.At(u, v) != kGoodsClass) continue;
      frame.instances.At(u, v) = u < frame.camera.width_px / 2 ? 1 : 2;
    }
  }
  Look(frame);
  const std::vector<FrameSegment> boxes = FindOf(kGoodsClass);
  ASSERT_EQ(boxes.size(), 2U);
  EXPECT_NE(boxes[0].instance, boxes[1].instance);
}

TEST_F(FrameSegmentsTest, SurfaceAtAFlatAngleIsOfTheSegmentOfItsInstance) {
  Frame frame = RenderScene({DistantWall(), BoxAt(1.5, -0.25, 0.25)}, {});
  const auto give_instance = [&](std::uint16_t instance) {
    frame.instances = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px, instance);
    Look(frame);
    for (std::size_t index = 0; index < samples_.size(); ++index) {
      if (samples_[index].position_world.y() > 0.0F) uses_[index] = SampleUse::kSurface;
    }
  };
  give_instance(0);
  ASSERT_EQ(FindOf(kGoodsClass).size(), 1U);
  EXPECT_NEAR(FindOf(kGoodsClass).front().area_m2, 0.25 * 0.6, 0.03);
  give_instance(1);
  ASSERT_EQ(FindOf(kGoodsClass).size(), 1U);
  EXPECT_NEAR(FindOf(kGoodsClass).front().area_m2, 0.5 * 0.6, 0.05);
}

TEST_F(FrameSegmentsTest, ExcludedSamplesAreInNoSegment) {
  Look(RenderScene({DistantWall(), BoxAt(1.5, -0.25, 0.25)}, {}));
  const std::size_t excluded = FindOf(kGoodsClass).front().samples.front();
  uses_[excluded] = SampleUse::kNone;
  for (const FrameSegment& segment : FindOf(kGoodsClass)) {
    EXPECT_EQ(std::count(segment.samples.begin(), segment.samples.end(), excluded), 0);
  }
}

}  // namespace
}  // namespace steadymap

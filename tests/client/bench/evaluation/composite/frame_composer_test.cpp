#include "client/bench/evaluation/composite/frame_composer.h"

#include <cmath>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr PinholeCamera kCamera = {320, 240, 300.0, 300.0, 160.0, 120.0};
constexpr double kWallM = 2.0;
constexpr double kThingM = 1.2;  // The front of the thing.

/// Returns a frame of a wall that faces the camera, at the origin along z.
Frame WallFrame() {
  Frame frame;
  frame.camera = kCamera;
  frame.depth.units = Image<std::uint16_t>(kCamera.width_px, kCamera.height_px, 2000);
  return frame;
}

Scene OneBox(double front_m) {
  Scene scene;
  SceneObject box;
  box.semantic_class = SceneClass::kGoods;
  box.shape = BoxShape{{0.4, 0.4, 0.2}};
  box.T_world_object = Eigen::Translation3d(0.0, 0.0, front_m + 0.1);
  scene.Add(box).instance = 1;
  return scene;
}

Frame Composed(const Scene& scene, RoomLabels labels) {
  SensorModel sensor = SensorModel::Ideal();
  sensor.stereo_baseline_m = StructuredLightModel().stereo_baseline_m;
  Frame frame = WallFrame();
  FrameComposer(&scene, kCamera, sensor).DrawInto(1, labels, &frame);
  return frame;
}

TEST(FrameComposer, AThingHidesWhatIsBehindIt) {
  const Frame frame = Composed(OneBox(kThingM), RoomLabels::kInstances);
  EXPECT_EQ(frame.depth.units.At(160, 120), 1200);
  EXPECT_EQ(frame.labels.At(160, 120), static_cast<std::uint16_t>(SceneClass::kGoods));
  EXPECT_EQ(frame.instances.At(160, 120), 1);
  EXPECT_EQ(frame.depth.units.At(300, 120), 2000);
  EXPECT_EQ(frame.labels.At(300, 120), 0);
}

TEST(FrameComposer, AThingBehindTheWallIsNotSeen) {
  const Scene scene = OneBox(kWallM + 0.5);
  const Frame frame = Composed(scene, RoomLabels::kClasses);
  EXPECT_EQ(frame.depth, WallFrame().depth);
  EXPECT_EQ(FrameComposer(&scene, kCamera, SensorModel::Ideal()).CountVisible(frame), 0U);
}

TEST(FrameComposer, AThingCastsAShadowToTheLeft) {
  const Frame frame = Composed(OneBox(kThingM), RoomLabels::kClasses);
  int first = 0;
  while (frame.depth.units.At(first, 120) == 2000) ++first;
  int end = first;
  while (frame.depth.units.At(end, 120) == kNoDepth) ++end;
  EXPECT_EQ(frame.depth.units.At(end, 120), 1200);
  const double shadow_px =
      kCamera.fx * StructuredLightModel().stereo_baseline_m * (1.0 / kThingM - 1.0 / kWallM);
  EXPECT_NEAR(end - first, shadow_px, 1.0);
  int last = kCamera.width_px - 1;
  while (frame.depth.units.At(last, 120) == 2000) --last;
  EXPECT_EQ(frame.depth.units.At(last, 120), 1200);
}

TEST(FrameComposer, WhatHasNoRecordedDepthIsFar) {
  const Scene scene = OneBox(kThingM);
  Frame frame = WallFrame();
  frame.depth.units = Image<std::uint16_t>(kCamera.width_px, kCamera.height_px, kNoDepth);
  FrameComposer composer(&scene, kCamera, SensorModel::Ideal());
  const double side_px = kCamera.fx * 0.4 / kThingM;
  EXPECT_NEAR(static_cast<double>(composer.CountVisible(frame)), side_px * side_px, 250.0);
  composer.DrawInto(1, RoomLabels::kNone, &frame);
  EXPECT_EQ(frame.depth.units.At(160, 120), 1200);
  EXPECT_TRUE(frame.labels.empty());
  EXPECT_TRUE(frame.instances.empty());
}

}  // namespace
}  // namespace steadymap

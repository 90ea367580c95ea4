#include "core/frame/frame.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kNan;

const KnownLabels& Labels() {
  static const KnownLabels labels(MapConfig().classes);
  return labels;
}

Frame ValidFrame() {
  Frame frame;
  frame.source = {"robot-1", SensorName::kDefaultSensor};
  frame.camera = {8, 6, 5.0, 5.0, 3.5, 2.5};
  frame.T_world_camera = Eigen::Translation3d(1.0, 2.0, 3.0) *
                         Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
  frame.depth.units = Image<std::uint16_t>(8, 6, 1000);
  frame.labels = Image<std::uint16_t>(8, 6, 15);
  frame.instances = Image<std::uint16_t>(8, 6, 65535);
  frame.color = Image<Rgb>(8, 6);
  return frame;
}

TEST(ValidateFrame, AcceptsAFrameWithAndWithoutItsOptionalImages) {
  Frame frame = ValidFrame();
  EXPECT_TRUE(ValidateFrame(frame, Labels()).ok());
  frame.labels = {};
  frame.instances = {};
  frame.color = {};
  EXPECT_TRUE(ValidateFrame(frame, Labels()).ok());
}

TEST(ValidateFrame, AcceptsTheEndsOfTheDepthUnit) {
  Frame frame = ValidFrame();
  for (const double metres_per_unit : {1e-6, 1e-1}) {
    frame.depth.metres_per_unit = metres_per_unit;
    EXPECT_TRUE(ValidateFrame(frame, Labels()).ok()) << metres_per_unit;
  }
}

TEST(ValidateFrame, NamesWhatIsWrongAndWhere) {
  struct Case {
    std::string_view reason;
    const char* field;
    std::function<void(Frame*)> spoil;
  };

  for (const Case& c : std::initializer_list<Case>{
           {reason::kBadIntrinsics, "intrinsics.fx", [](Frame* f) { f->camera.fx = -1.0; }},
           {reason::kBadDepthEncoding,
            "depth.metres_per_unit",
            [](Frame* f) { f->depth.metres_per_unit = 0.0; }},
           {reason::kBadDepthEncoding,
            "depth.metres_per_unit",
            [](Frame* f) { f->depth.metres_per_unit = kNan; }},
           {reason::kBadDepthEncoding,
            "depth.metres_per_unit",
            [](Frame* f) { f->depth.metres_per_unit = 0.11; }},
           {reason::kImageSizeMismatch, "depth", [](Frame* f) { f->depth.units = {}; }},
           {reason::kImageSizeMismatch,
            "depth",
            [](Frame* f) { f->depth.units = Image<std::uint16_t>(6, 8); }},
           {reason::kImageSizeMismatch,
            "labels",
            [](Frame* f) { f->labels = Image<std::uint16_t>(8, 5); }},
           {reason::kImageSizeMismatch,
            "instances",
            [](Frame* f) { f->instances = Image<std::uint16_t>(7, 6); }},
           {reason::kImageSizeMismatch, "color", [](Frame* f) { f->color = Image<Rgb>(9, 6); }},
           {reason::kLabelOutOfRange, "labels", [](Frame* f) { f->labels.At(7, 5) = 16; }},
           {reason::kNonFinitePose,
            "world_from_camera",
            [](Frame* f) { f->T_world_camera.translation().y() = kNan; }},
           {reason::kNonFinitePose,
            "world_from_camera",
            [](Frame* f) { f->T_world_camera.translation().x() = 1.1 * kMaxPositionM; }},
           {reason::kNonFinitePose,
            "world_from_camera",
            [](Frame* f) { f->T_world_camera.linear()(1, 2) = kNan; }},
           {reason::kNotARotation,
            "world_from_camera",
            [](Frame* f) { f->T_world_camera.linear() *= 1.01; }},
           {reason::kNotARotation, "world_from_camera", [](Frame* f) {
              f->T_world_camera.linear() *= -1.0;
            }}}) {
    Frame frame = ValidFrame();
    c.spoil(&frame);
    const absl::Status status = ValidateFrame(frame, Labels());
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << c.field;
    EXPECT_EQ(ReasonOf(status), c.reason) << status;
    EXPECT_EQ(FieldOf(status), c.field) << status;
  }
}

TEST(ValidateFrame, FindsTheOneBadLabelWhereverItIs) {
  for (int v = 0; v < 6; ++v) {
    for (int u = 0; u < 8; ++u) {
      Frame frame = ValidFrame();
      frame.labels.At(u, v) = 65535;
      EXPECT_EQ(ReasonOf(ValidateFrame(frame, Labels())), reason::kLabelOutOfRange);
    }
  }
}

}  // namespace
}  // namespace steadymap

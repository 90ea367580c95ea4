#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "proto/convert_status.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kNan;

/// A fault in a frame, and the error of the service.
struct BrokenFrame {
  const char* name;
  std::function<void(v1::Frame*)> spoil;
  const char* reason;
  const char* field;
};

void PrintTo(const BrokenFrame& broken, std::ostream* stream) { *stream << broken.name; }

std::vector<BrokenFrame> BrokenMetadata() {
  return {
      {"NoCaptureTime",
       [](v1::Frame* frame) { frame->clear_capture_time(); },
       "BAD_TIMESTAMP",
       "capture_time"},
      {"NegativeNanoseconds",
       [](v1::Frame* frame) { frame->mutable_capture_time()->set_nanos(-1); },
       "BAD_TIMESTAMP",
       "capture_time.nanos"},
      {"NoIntrinsics",
       [](v1::Frame* frame) { frame->clear_intrinsics(); },
       "BAD_INTRINSICS",
       "intrinsics.width_px"},
      {"HugeImage",
       [](v1::Frame* frame) { frame->mutable_intrinsics()->set_height_px(0xFFFFFFFFU); },
       "BAD_INTRINSICS",
       "intrinsics.height_px"},
      {"NanFocalLength",
       [](v1::Frame* frame) { frame->mutable_intrinsics()->set_fx(kNan); },
       "BAD_INTRINSICS",
       "intrinsics.fx"},
      {"NoPose",
       [](v1::Frame* frame) { frame->clear_world_from_camera(); },
       "NON_FINITE_POSE",
       "world_from_camera.position_m"},
      {"NanPosition",
       [](v1::Frame* frame) {
         frame->mutable_world_from_camera()->mutable_position_m()->set_z(kNan);
       },
       "NON_FINITE_POSE",
       "world_from_camera.position_m"},
      {"NanOrientation",
       [](v1::Frame* frame) {
         frame->mutable_world_from_camera()->mutable_orientation()->set_w(kNan);
       },
       "NON_FINITE_POSE",
       "world_from_camera.orientation"},
      {"ZeroQuaternion",
       [](v1::Frame* frame) { frame->mutable_world_from_camera()->clear_orientation(); },
       "NOT_A_ROTATION",
       "world_from_camera.orientation"},
  };
}

std::vector<BrokenFrame> ImpossibleMetadata() {
  return {
      {"TooShortFocalLength",
       [](v1::Frame* frame) { frame->mutable_intrinsics()->set_fy(0.5); },
       "BAD_INTRINSICS",
       "intrinsics.fy"},
      {"CaptureTimeFarAhead",
       [](v1::Frame* frame) { frame->mutable_capture_time()->set_seconds(7'000'000'000); },
       "BAD_CAPTURE_TIME",
       "capture_time"},
      {"UnknownClockDomain",
       [](v1::Frame* frame) { frame->set_clock_domain(static_cast<v1::ClockDomain>(77)); },
       "BAD_VALUE",
       "clock_domain"},
      {"ShortPoseCovariance",
       [](v1::Frame* frame) { frame->mutable_pose_covariance()->add_upper_triangle(1.0); },
       "BAD_VALUE",
       "pose_covariance.upper_triangle"},
      {"NegativePoseVariance",
       [](v1::Frame* frame) {
         auto* numbers = frame->mutable_pose_covariance()->mutable_upper_triangle();
         numbers->Resize(21, 0.0);
         numbers->Set(6, -1e-9);  // Of y.
       },
       "BAD_VALUE",
       "pose_covariance.upper_triangle"},
  };
}

std::vector<BrokenFrame> BrokenDepth() {
  return {
      {"NoDepth",
       [](v1::Frame* frame) { frame->clear_depth(); },
       "BAD_DEPTH_ENCODING",
       "depth.encoding"},
      {"UnknownDepthEncoding",
       [](v1::Frame* frame) {
         frame->mutable_depth()->set_encoding(static_cast<v1::DepthEncoding>(99));
       },
       "BAD_DEPTH_ENCODING",
       "depth.encoding"},
      {"NanDepthUnit",
       [](v1::Frame* frame) { frame->mutable_depth()->set_metres_per_unit(kNan); },
       "BAD_DEPTH_ENCODING",
       "depth.metres_per_unit"},
      {"ShortDepth",
       [](v1::Frame* frame) { frame->mutable_depth()->mutable_data()->pop_back(); },
       "IMAGE_SIZE_MISMATCH",
       "depth.data"},
      {"DepthThatIsNoPng",
       [](v1::Frame* frame) {
         frame->mutable_depth()->set_encoding(v1::DEPTH_ENCODING_PNG_UINT16);
       },
       "BAD_DEPTH_ENCODING",
       "depth.data"},
      {"DepthThatIsNoZstd",
       [](v1::Frame* frame) {
         frame->mutable_depth()->set_encoding(v1::DEPTH_ENCODING_ZSTD_UINT16);
       },
       "BAD_DEPTH_ENCODING",
       "depth.data"},
      {"TruncatedPng",
       [](v1::Frame* frame) {
         WallFrame wall;
         wall.encoding = v1::DEPTH_ENCODING_PNG_UINT16;
         *frame = MakeWallFrame(wall);
         std::string* data = frame->mutable_depth()->mutable_data();
         data->resize(data->size() / 2);
       },
       "BAD_DEPTH_ENCODING",
       "depth.data"},
  };
}

std::vector<BrokenFrame> BrokenImages() {
  return {
      {"LabelsWithoutEncoding",
       [](v1::Frame* frame) { frame->mutable_labels()->clear_encoding(); },
       "BAD_IMAGE_ENCODING",
       "labels.encoding"},
      {"LabelBeyondTheClassTable",
       [](v1::Frame* frame) { frame->mutable_labels()->mutable_data()->back() = 16; },
       "LABEL_OUT_OF_RANGE",
       "labels"},
      {"ShortInstances",
       [](v1::Frame* frame) {
         frame->mutable_instances()->set_encoding(v1::LABEL_ENCODING_RAW_UINT16);
       },
       "IMAGE_SIZE_MISMATCH",
       "instances.data"},
      {"ColorWithoutEncoding",
       [](v1::Frame* frame) { frame->mutable_color()->set_data("x"); },
       "BAD_IMAGE_ENCODING",
       "color.encoding"},
      {"ColorThatIsNoJpeg",
       [](v1::Frame* frame) {
         frame->mutable_color()->set_encoding(v1::COLOR_ENCODING_JPEG);
         frame->mutable_color()->set_data("x");
       },
       "BAD_IMAGE_ENCODING",
       "color.data"},
  };
}

class RefusedFrameTest : public ::testing::TestWithParam<BrokenFrame> {
 protected:
  TestService service_{Transport::kLoopback};
  const UploadSession session_{service_.CreateMap("hall")};
};

constexpr auto kWayName = [](const ::testing::TestParamInfo<BrokenFrame>& way) {
  return way.param.name;
};

INSTANTIATE_TEST_SUITE_P(Metadata,
                         RefusedFrameTest,
                         ::testing::ValuesIn(BrokenMetadata()),
                         kWayName);

INSTANTIATE_TEST_SUITE_P(CorruptRecord,
                         RefusedFrameTest,
                         ::testing::ValuesIn(ImpossibleMetadata()),
                         kWayName);
INSTANTIATE_TEST_SUITE_P(Depth, RefusedFrameTest, ::testing::ValuesIn(BrokenDepth()), kWayName);
INSTANTIATE_TEST_SUITE_P(Images, RefusedFrameTest, ::testing::ValuesIn(BrokenImages()), kWayName);

TEST_P(RefusedFrameTest, IsRefusedAloneWithReasonAndFieldPath) {
  v1::FrameBatch batch = MakeBatch(1, 3);
  GetParam().spoil(batch.mutable_frames(1));
  const absl::StatusOr<v1::UploadAck> ack =
      UploadByCall(&service_, session_, batch, v1::ACK_LEVEL_INTEGRATED);
  ASSERT_TRUE(ack.ok()) << ack.status();
  ASSERT_EQ(ack->refused_size(), 1);
  EXPECT_EQ(ack->refused(0).client_seq(), 2U);
  EXPECT_THAT(FromProto(ack->refused(0).status()),
              IsError(absl::StatusCode::kInvalidArgument,
                      GetParam().reason,
                      std::string("frames[1].") + GetParam().field));
  EXPECT_EQ(ack->map_seq(), 2U);
  EXPECT_EQ(ack->revision(), 2U);
}

}  // namespace
}  // namespace steadymap

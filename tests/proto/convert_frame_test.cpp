#include "proto/convert_frame.h"

#include <gtest/gtest.h>

#include "core/frame/image_codec.h"
#include "core/types/error.h"
#include "tests/support/thread_limit.h"
#include "tests/support/wall_frame.h"

namespace steadymap {
namespace {

const SensorName kSource{"robot", "left"};

const KnownLabels& Labels() {
  static const KnownLabels labels(MapConfig().classes);
  return labels;
}

// tests/contract/refused_frame_test.cpp tests each refusal of a frame through the service.

TEST(ConvertFrame, EveryDepthEncodingGivesTheSamePixels) {
  const absl::StatusOr<Frame> raw = FromProto(MakeWallFrame(), kSource, Labels());
  ASSERT_TRUE(raw.ok()) << raw.status();
  EXPECT_EQ(raw->source, kSource);
  EXPECT_EQ(raw->depth.units.At(0, 0), 2000);
  EXPECT_EQ(raw->labels.At(63, 47), 4);
  EXPECT_EQ(raw->capture_time, Timestamp::FromSeconds(100.0));
  for (const auto encoding : {v1::DEPTH_ENCODING_PNG_UINT16, v1::DEPTH_ENCODING_ZSTD_UINT16}) {
    const auto packed = FromProto(MakeWallFrame({.encoding = encoding}), kSource, Labels());
    ASSERT_TRUE(packed.ok()) << packed.status();
    EXPECT_EQ(packed->depth, raw->depth);
  }
}

TEST(ConvertFrame, TheDepthSensorIsReadAndAnUnknownOneRefused) {
  v1::Frame message = MakeWallFrame();
  EXPECT_EQ(FromProto(message, kSource, Labels())->depth.sensor, DepthSensorKind::kUnknown);
  for (const auto& [sensor, kind] :
       {std::pair{v1::DEPTH_SENSOR_STRUCTURED_LIGHT, DepthSensorKind::kStructuredLight},
        {v1::DEPTH_SENSOR_STEREO, DepthSensorKind::kStereo},
        {v1::DEPTH_SENSOR_TIME_OF_FLIGHT, DepthSensorKind::kTimeOfFlight},
        {v1::DEPTH_SENSOR_LIDAR, DepthSensorKind::kLidar}}) {
    message.mutable_depth()->set_sensor(sensor);
    EXPECT_EQ(FromProto(message, kSource, Labels())->depth.sensor, kind);
  }
  message.mutable_depth()->set_sensor(static_cast<v1::DepthSensor>(99));
  const absl::Status refused = FromProto(message, kSource, Labels()).status();
  EXPECT_EQ(ReasonOf(refused), reason::kBadValue);
  EXPECT_EQ(FieldOf(refused), "depth.sensor");
}

TEST(ConvertFrame, EveryLabelEncodingGivesTheSamePixels) {
  const Image<std::uint16_t> labels(64, 48, 7);
  const std::pair<v1::LabelEncoding, PixelEncoding> encodings[] = {
      {v1::LABEL_ENCODING_RAW_UINT8, PixelEncoding::kRawUint8},
      {v1::LABEL_ENCODING_RAW_UINT16, PixelEncoding::kRawUint16},
      {v1::LABEL_ENCODING_PNG, PixelEncoding::kPng},
      {v1::LABEL_ENCODING_ZSTD_UINT8, PixelEncoding::kZstdUint8},
      {v1::LABEL_ENCODING_ZSTD_UINT16, PixelEncoding::kZstdUint16}};
  for (const auto& [wire, packing] : encodings) {
    v1::Frame message = MakeWallFrame();
    message.mutable_labels()->set_encoding(wire);
    message.mutable_labels()->set_data(EncodePixels(labels, packing));
    *message.mutable_instances() = message.labels();
    const auto frame = FromProto(message, kSource, Labels());
    ASSERT_TRUE(frame.ok()) << frame.status();
    EXPECT_EQ(frame->labels, labels);
    EXPECT_EQ(frame->instances, labels);
  }
}

TEST(ConvertFrame, AbsentOptionalImagesStayEmpty) {
  const auto frame = FromProto(MakeWallFrame({.with_labels = false}), kSource, Labels());
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_TRUE(frame->labels.empty());
  EXPECT_TRUE(frame->instances.empty());
  EXPECT_TRUE(frame->color.empty());
}

TEST(ConvertFrame, ColorIsDecoded) {
  const Image<Rgb> color(64, 48, Rgb{10, 20, 30});
  v1::Frame message = MakeWallFrame();
  message.mutable_color()->set_encoding(v1::COLOR_ENCODING_PNG);
  message.mutable_color()->set_data(EncodeColorPng(color));
  const auto frame = FromProto(message, kSource, Labels());
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->color, color);
}

/// Returns a frame large enough that its images are decoded in parallel.
v1::Frame LargeFrame() {
  v1::Frame message = MakeWallFrame({.width_px = 320, .height_px = 240});
  const Image<std::uint16_t> instances(320, 240, 3);
  message.mutable_instances()->set_encoding(v1::LABEL_ENCODING_PNG);
  message.mutable_instances()->set_data(EncodePixels(instances, PixelEncoding::kPng));
  message.mutable_color()->set_encoding(v1::COLOR_ENCODING_PNG);
  message.mutable_color()->set_data(EncodeColorPng(Image<Rgb>(320, 240, Rgb{10, 20, 30})));
  return message;
}

TEST(ConvertFrame, ImagesAreTheSameOnAnyNumberOfThreads) {
  const auto decode = [] { return FromProto(LargeFrame(), kSource, Labels()); };
  const absl::StatusOr<Frame> alone = testing::RunOnThreads(1, decode);
  ASSERT_TRUE(alone.ok()) << alone.status();
  for (const int threads : {2, 8}) {
    const absl::StatusOr<Frame> frame = testing::RunOnThreads(threads, decode);
    ASSERT_TRUE(frame.ok()) << frame.status();
    EXPECT_EQ(frame->depth, alone->depth);
    EXPECT_EQ(frame->labels, alone->labels);
    EXPECT_EQ(frame->instances, alone->instances);
    EXPECT_EQ(frame->color, alone->color);
  }
}

TEST(ConvertFrame, ErrorIsThatOfTheFirstImageThatHasOne) {
  v1::Frame message = LargeFrame();
  message.mutable_color()->set_data("no picture");
  const auto decode = [&message] { return FromProto(message, kSource, Labels()).status(); };
  EXPECT_EQ(FieldOf(testing::RunOnThreads(8, decode)), "color.data");
  message.mutable_labels()->set_data("no picture, either");
  EXPECT_EQ(FieldOf(testing::RunOnThreads(8, decode)), "labels.data");
}

TEST(ConvertFrame, ZstdBombIsRefusedWithoutBeingUnpacked) {
  v1::Frame message = MakeWallFrame();
  const Image<std::uint16_t> huge(4096, 4096, 1000);
  message.mutable_depth()->set_encoding(v1::DEPTH_ENCODING_ZSTD_UINT16);
  message.mutable_depth()->set_data(EncodePixels(huge, PixelEncoding::kZstdUint16));
  EXPECT_EQ(ReasonOf(FromProto(message, kSource, Labels()).status()), "IMAGE_SIZE_MISMATCH");
}

TEST(ConvertCamera, ComesBack) {
  const PinholeCamera camera{640, 480, 525.5, 526.5, 319.5, 239.5};
  EXPECT_EQ(*FromProto(ToProto(camera)), camera);
}

TEST(ConvertCamera, SideThatFitsNoIntIsRefused) {
  v1::CameraIntrinsics message = ToProto(PinholeCamera{640, 480, 500, 500, 320, 240});
  message.set_width_px(0x80000001U);
  EXPECT_EQ(FieldOf(FromProto(message).status()), "width_px");
}

}  // namespace
}  // namespace steadymap

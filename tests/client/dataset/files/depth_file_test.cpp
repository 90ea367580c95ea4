#include "client/dataset/files/depth_file.h"

#include <cstdint>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/frame/image_codec.h"
#include "tests/client/dataset/files/float_image_writer.h"
#include "tests/client/dataset/recording_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr PinholeCamera kCamera = {40, 30, 35.0, 35.0, 20.0, 15.0};

// Every pixel has a different depth, exact in half floats too.
Image<float> Ramp() {
  Image<float> image(kCamera.width_px, kCamera.height_px);
  for (std::size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = 1.0F + static_cast<float>(i) / 1024.0F;
  }
  return image;
}

absl::StatusOr<Image<std::uint16_t>> ReadUnits(const std::filesystem::path& file,
                                               double metres_per_unit) {
  v1::DepthImage message;
  const absl::Status status = PackDepthFile(file, kCamera, metres_per_unit, &message);
  if (!status.ok()) return status;
  EXPECT_EQ(message.encoding(), v1::DEPTH_ENCODING_ZSTD_UINT16);
  EXPECT_EQ(message.metres_per_unit(), metres_per_unit);
  return DecodeDepth(
      message.data(), PixelEncoding::kZstdUint16, kCamera.width_px, kCamera.height_px);
}

std::string MessageOf(const std::filesystem::path& file) {
  const auto units = ReadUnits(file, 0.001);
  EXPECT_FALSE(units.ok());
  return std::string(units.status().message());
}

void ExpectRamp(const std::filesystem::path& file) {
  const auto units = ReadUnits(file, 1.0 / 1024.0);
  ASSERT_TRUE(units.ok()) << units.status();
  for (std::size_t i = 0; i < units->size(); ++i) ASSERT_EQ(units->data()[i], 1024 + i) << file;
}

TEST(PackDepthFile, ReadsEveryPixelOfAnExrFile) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "depth.exr";
  WriteExr(file, Ramp());
  ExpectRamp(file);
  WriteExr(file, Ramp(), "R", {.channels = {"R", "G", "B"}});
  ExpectRamp(file);
  WriteExr(file, Ramp(), "R", {.channels = {"R", "G", "B", "A"}});
  ExpectRamp(file);
  WriteExr(file, Ramp(), "Z", {.channels = {"Z", "R", "G", "B", "A"}});
  ExpectRamp(file);
  WriteExr(file, Ramp(), "Depth.V", {.channels = {"Depth.V", "A"}});
  ExpectRamp(file);
}

TEST(PackDepthFile, ReadsHalfFloats) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "depth.EXR";
  Image<float> image(kCamera.width_px, kCamera.height_px, 1.5F);
  image.At(39, 29) = 2.25F;
  WriteExr(file, image, "R", {.channels = {"R", "G", "B"}, .is_half = true});
  const auto units = ReadUnits(file, 0.001);
  ASSERT_TRUE(units.ok()) << units.status();
  EXPECT_EQ(units->At(0, 0), 1500);
  EXPECT_EQ(units->At(39, 29), 2250);
}

TEST(PackDepthFile, ReadsEveryPixelOfATiffFile) {
  const TemporaryFolder folder;
  WriteTiff(folder.path() / "depth.tiff", Ramp());
  ExpectRamp(folder.path() / "depth.tiff");
  WriteTiff(folder.path() / "depth.tif", Ramp(), /*is_compressed=*/true);
  ExpectRamp(folder.path() / "depth.tif");
}

TEST(PackDepthFile, WhatIsNoDepthBecomesZero) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kMax = std::numeric_limits<float>::max();
  const TemporaryFolder folder;
  Image<float> image(kCamera.width_px, kCamera.height_px, 1.0F);
  int column = 0;
  for (const float value : {std::numeric_limits<float>::quiet_NaN(),
                            kInfinity,
                            -kInfinity,
                            0.0F,
                            -1.0F,
                            kMax,
                            65.535F,
                            0.0004F}) {
    image.At(column++, 0) = value;
  }
  image.At(column, 0) = 65.534F;
  WriteTiff(folder.path() / "depth.tiff", image);
  WriteExr(folder.path() / "depth.exr", image);
  for (const char* name : {"depth.tiff", "depth.exr"}) {
    const auto units = ReadUnits(folder.path() / name, 0.001);
    ASSERT_TRUE(units.ok()) << units.status();
    for (int i = 0; i < column; ++i) EXPECT_EQ(units->At(i, 0), 0) << name << " " << i;
    EXPECT_EQ(units->At(column, 0), 65534);
    EXPECT_EQ(units->At(0, 1), 1000);
  }
}

TEST(PackDepthFile, RefusesAnotherSizeNamingBoth) {
  const TemporaryFolder folder;
  WriteTiff(folder.path() / "depth.tiff", Image<float>(41, 30, 1.0F));
  WriteExr(folder.path() / "depth.exr", Image<float>(41, 30, 1.0F));
  for (const char* name : {"depth.tiff", "depth.exr"}) {
    const std::string message = MessageOf(folder.path() / name);
    EXPECT_THAT(message, HasSubstr(name));
    EXPECT_THAT(message, HasSubstr("40 x 30"));
    EXPECT_THAT(message, HasSubstr("41 x 30"));
  }
}

TEST(PackDepthFile, RefusesFilesThatAreMissingOrSomethingElse) {
  const TemporaryFolder folder;
  for (const char* name : {"depth.tiff", "depth.exr", "depth.png"}) {
    EXPECT_THAT(MessageOf(folder.path() / name), HasSubstr(name));
    for (const char* text : {"", "II*", "no image at all, but some bytes"}) {
      folder.Write(name, text);
      EXPECT_THAT(MessageOf(folder.path() / name), HasSubstr(name));
      EXPECT_THAT(MessageOf(folder.path() / name), HasSubstr("expected"));
    }
  }
  folder.Write("depth.tiff", DepthPng(40, 30, 1000));
  EXPECT_THAT(MessageOf(folder.path() / "depth.tiff"), HasSubstr("TIFF"));
  WriteExr(folder.path() / "depth.exr", Ramp(), "V", {.is_tiled = true});
  EXPECT_THAT(MessageOf(folder.path() / "depth.exr"), HasSubstr("tiles"));
  WriteExr(folder.path() / "depth.exr", Ramp(), "A", {.channels = {"A"}});
  EXPECT_THAT(MessageOf(folder.path() / "depth.exr"), HasSubstr("channel"));
}

// Expects that a file is read or refused with an error that names it.
void ExpectReadOrRefused(const TemporaryFolder& folder,
                         const std::string& name,
                         const std::string& content) {
  const std::filesystem::path file = folder.Write(name, content);
  const auto units = ReadUnits(file, 0.001);
  if (units.ok()) return;
  EXPECT_THAT(std::string(units.status().message()), HasSubstr(name));
}

TEST(PackDepthFile, SurvivesTruncatedAndDamagedFiles) {
  const TemporaryFolder folder;
  WriteTiff(folder.path() / "depth.tiff", Ramp());
  WriteTiff(folder.path() / "deflated.tiff", Ramp(), /*is_compressed=*/true);
  WriteExr(folder.path() / "depth.exr", Ramp(), "R", {.channels = {"R", "G", "B"}});
  for (const char* name : {"depth.tiff", "deflated.tiff", "depth.exr"}) {
    const std::string whole = ContentOf(folder.path() / name);
    for (std::size_t length = 0; length < whole.size(); length += whole.size() / 20) {
      folder.Write(name, whole.substr(0, length));
      EXPECT_THAT(MessageOf(folder.path() / name), HasSubstr(name));
    }
    // The image header is at the beginning of one format and at the end of the other.
    for (std::size_t i = 0; i < 300; i += 4) {
      for (const std::size_t place : {i, whole.size() - 1 - i}) {
        std::string damaged = whole;
        damaged[place] = '\xff';
        ExpectReadOrRefused(folder, name, damaged);
      }
    }
  }
}

TEST(PackDepthFile, RefusesHugeDeclaredSizesBeforeAllocating) {
  const TemporaryFolder folder;
  WriteExr(folder.path() / "depth.exr", Ramp());
  std::string exr = ContentOf(folder.path() / "depth.exr");
  const std::string window("dataWindow\0box2i\0\x10\0\0\0", 21);
  const std::size_t at = exr.find(window);
  ASSERT_NE(at, std::string::npos);
  for (std::size_t side : {8U, 12U}) exr.replace(at + window.size() + side, 4, "\xff\xff\xff\x3f");
  folder.Write("depth.exr", exr);
  EXPECT_THAT(MessageOf(folder.path() / "depth.exr"), HasSubstr("depth.exr"));

  // A little-endian TIFF directory with only width and height.
  const std::string tiff(
      "II*\0\x08\0\0\0\x02\0"
      "\0\x01\x04\0\x01\0\0\0\xff\xff\xff\xff"
      "\x01\x01\x04\0\x01\0\0\0\xff\xff\xff\xff"
      "\0\0\0\0",
      38);
  folder.Write("depth.tiff", tiff);
  EXPECT_THAT(MessageOf(folder.path() / "depth.tiff"),
              AnyOf(HasSubstr("2147483647"), HasSubstr("TIFF")));
}

}  // namespace
}  // namespace steadymap

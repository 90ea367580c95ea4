#include "core/frame/image_codec.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/core/frame/image_builder.h"

namespace steadymap {
namespace {

constexpr PixelEncoding kAllEncodings[] = {PixelEncoding::kRawUint8,
                                           PixelEncoding::kRawUint16,
                                           PixelEncoding::kPng,
                                           PixelEncoding::kZstdUint8,
                                           PixelEncoding::kZstdUint16};

bool IsEightBit(PixelEncoding encoding) {
  return encoding == PixelEncoding::kRawUint8 || encoding == PixelEncoding::kZstdUint8;
}

TEST(DecodePixels, GivesBackWhatEncodePixelsPackedInEveryEncoding) {
  std::mt19937 random(1);
  for (int round = 0; round < 40; ++round) {
    const int width_px = std::uniform_int_distribution<int>(1, 70)(random);
    const int height_px = std::uniform_int_distribution<int>(1, 50)(random);
    for (const PixelEncoding encoding : kAllEncodings) {
      const Image<std::uint16_t> image =
          RandomPixels(width_px, height_px, IsEightBit(encoding) ? 255 : 65535, &random);
      const auto decoded =
          DecodePixels(EncodePixels(image, encoding), encoding, width_px, height_px);
      ASSERT_TRUE(decoded.ok()) << decoded.status();
      EXPECT_EQ(*decoded, image);
    }
  }
}

TEST(DecodeDepth, GivesBackSixteenBitImages) {
  std::mt19937 random(2);
  const Image<std::uint16_t> image = RandomPixels(33, 21, 65535, &random);
  for (const PixelEncoding encoding :
       {PixelEncoding::kRawUint16, PixelEncoding::kPng, PixelEncoding::kZstdUint16}) {
    const auto decoded = DecodeDepth(EncodePixels(image, encoding), encoding, 33, 21);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(*decoded, image);
  }
}

TEST(DecodeDepth, RefusesEightBitPixels) {
  const Image<std::uint16_t> image(4, 3, 7);
  for (const PixelEncoding encoding : {PixelEncoding::kRawUint8, PixelEncoding::kZstdUint8}) {
    const absl::Status status = DecodeDepth(EncodePixels(image, encoding), encoding, 4, 3).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(ReasonOf(status), reason::kBadDepthEncoding);
    EXPECT_EQ(FieldOf(status), "encoding");
  }
  const absl::Status status =
      DecodeDepth(EncodePixels(image, PixelEncoding::kPng), PixelEncoding::kPng, 4, 3).status();
  EXPECT_EQ(ReasonOf(status), reason::kBadDepthEncoding);
  EXPECT_EQ(FieldOf(status), "data");
}

TEST(EncodePixels, WritesPixelsLittleEndianWhenRaw) {
  Image<std::uint16_t> image(2, 1);
  image.At(0, 0) = 0x1234;
  image.At(1, 0) = 0x00ff;
  EXPECT_EQ(EncodePixels(image, PixelEncoding::kRawUint16), std::string("\x34\x12\xff\0", 4));
}

TEST(EncodePixels, WritesSixteenBitPngWhereAPixelNeedsItOrTheCallerAsks) {
  const Image<std::uint16_t> narrow(5, 4, 255);
  const Image<std::uint16_t> wide(5, 4, 256);
  // Byte 24 of a PNG file is the bit depth.
  EXPECT_EQ(EncodePixels(narrow, PixelEncoding::kPng)[24], 8);
  EXPECT_EQ(EncodePixels(narrow, PixelEncoding::kPng, true)[24], 16);
  EXPECT_EQ(EncodePixels(wide, PixelEncoding::kPng)[24], 16);
}

TEST(EncodePixels, GivesNothingForAnEmptyImageInPng) {
  EXPECT_TRUE(EncodePixels({}, PixelEncoding::kPng).empty());
  EXPECT_TRUE(EncodeColorPng({}).empty());
}

TEST(DecodeColor, GivesBackWhatEncodeColorPngPacked) {
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    const Image<Rgb> image = RandomColors(1 + round * 3, 41 - round * 2, &random);
    const auto decoded = DecodeColor(
        EncodeColorPng(image), ColorEncoding::kPng, image.width_px(), image.height_px());
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(*decoded, image);
  }
}

TEST(DecodeColor, ReadsRawTriples) {
  const auto decoded = DecodeColor("abcdef", ColorEncoding::kRawRgb8, 2, 1);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->At(1, 0), (Rgb{'d', 'e', 'f'}));
  EXPECT_EQ(ReasonOf(DecodeColor("abcde", ColorEncoding::kRawRgb8, 2, 1).status()),
            reason::kImageSizeMismatch);
}

TEST(DecodeColor, ReadsColourAndGreyJpegWithinItsLoss) {
  for (const bool progressive : {false, true}) {
    const auto decoded = DecodeColor(
        MakeJpeg({40, 30, 3, {200, 90, 30}, progressive}), ColorEncoding::kJpeg, 40, 30);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    for (std::size_t channel = 0; channel < 3; ++channel) {
      EXPECT_NEAR(decoded->At(17, 11)[channel], (Rgb{200, 90, 30})[channel], 3);
    }
  }
  const auto grey = DecodeColor(MakeJpeg({40, 30, 1, {77, 77, 77}}), ColorEncoding::kJpeg, 40, 30);
  ASSERT_TRUE(grey.ok()) << grey.status();
  EXPECT_EQ(grey->At(39, 29), (Rgb{77, 77, 77}));
}

TEST(DecodeColor, ConvertsEveryPngColourTypeToRgb) {
  struct Case {
    PngKind kind;
    std::vector<std::uint8_t> pixel;
    Rgb expected;
  };

  for (const Case& c :
       {Case{{.color_type = kPngGrey, .bit_depth = 8}, {90}, {90, 90, 90}},
        Case{{.color_type = kPngGrey, .bit_depth = 16}, {0xff, 0xff}, {255, 255, 255}},
        Case{{.color_type = kPngGreyAlpha, .bit_depth = 8}, {90, 3}, {90, 90, 90}},
        Case{{.color_type = kPngRgb, .bit_depth = 8}, {1, 2, 3}, {1, 2, 3}},
        Case{{.color_type = kPngRgbAlpha, .bit_depth = 8}, {1, 2, 3, 4}, {1, 2, 3}},
        Case{{.color_type = kPngPalette, .bit_depth = 8}, {2}, {102, 152, 202}}}) {
    const std::string file = MakePng(3, 2, c.kind, c.pixel);
    const auto decoded = DecodeColor(file, ColorEncoding::kPng, 3, 2);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(*decoded, Image<Rgb>(3, 2, c.expected));
  }
}

TEST(DecodePixels, ReadsPaletteIndicesNotTheirColours) {
  const std::string file = MakePng(3, 2, {.color_type = kPngPalette, .bit_depth = 8}, {2});
  const auto decoded = DecodePixels(file, PixelEncoding::kPng, 3, 2);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(*decoded, Image<std::uint16_t>(3, 2, 2));
}

TEST(DecodePixels, ReadsBigEndianPngPixels) {
  const std::string file = MakePng(3, 2, {.color_type = kPngGrey, .bit_depth = 16}, {0x12, 0x34});
  const auto decoded = DecodePixels(file, PixelEncoding::kPng, 3, 2);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(*decoded, Image<std::uint16_t>(3, 2, 0x1234));
}

TEST(PeekImageSize, ReadsTheHeaderAlone) {
  const std::string png = EncodeColorPng(Image<Rgb>(31, 17));
  const auto png_size = PeekImageSize(png.substr(0, 24));
  ASSERT_TRUE(png_size.ok()) << png_size.status();
  EXPECT_EQ(png_size->width_px, 31);
  EXPECT_EQ(png_size->height_px, 17);

  const auto jpeg_size = PeekImageSize(MakeJpeg({.width_px = 31, .height_px = 17}));
  ASSERT_TRUE(jpeg_size.ok()) << jpeg_size.status();
  EXPECT_EQ(jpeg_size->width_px, 31);
  EXPECT_EQ(jpeg_size->height_px, 17);
}

TEST(PeekImageSize, RefusesWhatIsNoImageFile) {
  for (const std::string& data : {std::string(), std::string("GIF89a"), std::string(64, '\0')}) {
    EXPECT_EQ(ReasonOf(PeekImageSize(data).status()), reason::kBadImageEncoding);
  }
}

}  // namespace
}  // namespace steadymap

#include <cstddef>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/frame/image_codec.h"
#include "core/types/error.h"
#include "tests/core/frame/image_builder.h"

namespace steadymap {
namespace {

// A decoder, the name of its encoding and a small valid file.
struct Subject {
  const char* name;
  std::string file;
  std::function<absl::Status(std::string_view data, int width_px, int height_px)> decode;
  // Whether the format has a checksum, so that the decoder must detect every changed byte.
  bool checksummed;
};

constexpr int kImageWidthPx = 9;
constexpr int kImageHeightPx = 7;

// Returns the status of a decoding. Fails the test if the image has a wrong size.
template <typename Pixel>
absl::Status StatusOf(const absl::StatusOr<Image<Pixel>>& image, int width_px, int height_px) {
  if (image.ok()) {
    EXPECT_EQ(image->width_px(), width_px);
    EXPECT_EQ(image->height_px(), height_px);
    EXPECT_EQ(image->size(), static_cast<std::size_t>(width_px * height_px));
  }
  return image.status();
}

Subject PixelSubject(const char* name, PixelEncoding encoding, std::string file, bool checksummed) {
  return {name,
          std::move(file),
          [encoding](std::string_view data, int width_px, int height_px) {
            return StatusOf(DecodePixels(data, encoding, width_px, height_px), width_px, height_px);
          },
          checksummed};
}

Subject ColorSubject(const char* name, ColorEncoding encoding, std::string file, bool checksummed) {
  return {name,
          std::move(file),
          [encoding](std::string_view data, int width_px, int height_px) {
            return StatusOf(DecodeColor(data, encoding, width_px, height_px), width_px, height_px);
          },
          checksummed};
}

std::vector<Subject> Subjects() {
  std::mt19937 random(4);
  const Image<std::uint16_t> narrow = RandomPixels(kImageWidthPx, kImageHeightPx, 255, &random);
  const Image<std::uint16_t> wide = RandomPixels(kImageWidthPx, kImageHeightPx, 65535, &random);
  const Image<Rgb> colors = RandomColors(kImageWidthPx, kImageHeightPx, &random);
  const JpegKind jpeg{kImageWidthPx, kImageHeightPx, 3, {10, 90, 200}, false};
  const JpegKind progressive{kImageWidthPx, kImageHeightPx, 3, {10, 90, 200}, true};
  std::vector<Subject> subjects;
  for (const auto& [name, encoding] : {std::pair{"raw8", PixelEncoding::kRawUint8},
                                       std::pair{"zstd8", PixelEncoding::kZstdUint8}}) {
    subjects.push_back(PixelSubject(name, encoding, EncodePixels(narrow, encoding), false));
  }
  for (const auto& [name, encoding] : {std::pair{"raw16", PixelEncoding::kRawUint16},
                                       std::pair{"zstd16", PixelEncoding::kZstdUint16}}) {
    subjects.push_back(PixelSubject(name, encoding, EncodePixels(wide, encoding), false));
  }
  for (const auto& [name, image] : {std::pair{"png8", &narrow}, std::pair{"png16", &wide}}) {
    subjects.push_back(
        PixelSubject(name, PixelEncoding::kPng, EncodePixels(*image, PixelEncoding::kPng), true));
  }
  subjects.push_back(
      PixelSubject("png palette",
                   PixelEncoding::kPng,
                   MakePng(kImageWidthPx, kImageHeightPx, {.color_type = kPngPalette}, {1}),
                   true));
  subjects.push_back(ColorSubject("png rgb", ColorEncoding::kPng, EncodeColorPng(colors), true));
  subjects.push_back(ColorSubject("jpeg", ColorEncoding::kJpeg, MakeJpeg(jpeg), false));
  subjects.push_back(
      ColorSubject("progressive jpeg", ColorEncoding::kJpeg, MakeJpeg(progressive), false));
  return subjects;
}

void ExpectImageRefusal(const absl::Status& status) {
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  EXPECT_TRUE(ReasonOf(status) == reason::kBadImageEncoding ||
              ReasonOf(status) == reason::kImageSizeMismatch)
      << status;
  EXPECT_EQ(FieldOf(status), "data") << status;
}

TEST(ImageDecoders, AcceptTheUndamagedFile) {
  for (const Subject& subject : Subjects()) {
    EXPECT_TRUE(subject.decode(subject.file, kImageWidthPx, kImageHeightPx).ok()) << subject.name;
  }
}

TEST(ImageDecoders, RefuseAFileCutAtAnyByte) {
  for (const Subject& subject : Subjects()) {
    SCOPED_TRACE(subject.name);
    for (std::size_t length = 0; length < subject.file.size(); ++length) {
      SCOPED_TRACE(length);
      // A separate allocation, so that a sanitizer detects a read beyond the truncation.
      const std::vector<char> cut(subject.file.begin(),
                                  subject.file.begin() + static_cast<std::ptrdiff_t>(length));
      ExpectImageRefusal(subject.decode({cut.data(), cut.size()}, kImageWidthPx, kImageHeightPx));
    }
  }
}

TEST(ImageDecoders, RefuseBytesAfterTheImage) {
  for (const Subject& subject : Subjects()) {
    SCOPED_TRACE(subject.name);
    for (const std::string& tail : {std::string(1, '\0'), std::string("garbage"), subject.file}) {
      ExpectImageRefusal(subject.decode(subject.file + tail, kImageWidthPx, kImageHeightPx));
    }
  }
}

TEST(ImageDecoders, SurviveEveryFlippedBitAndFindItWhereTheFormatCan) {
  for (const Subject& subject : Subjects()) {
    SCOPED_TRACE(subject.name);
    for (std::size_t i = 0; i < subject.file.size() * 8; ++i) {
      std::string damaged = subject.file;
      damaged[i / 8] = static_cast<char>(damaged[i / 8] ^ (1 << (i % 8)));
      const absl::Status status = subject.decode(damaged, kImageWidthPx, kImageHeightPx);
      if (!status.ok()) ExpectImageRefusal(status);
      EXPECT_FALSE(status.ok() && subject.checksummed) << "bit " << i;
    }
  }
}

TEST(ImageDecoders, RefuseAnImageOfAnotherSize) {
  for (const Subject& subject : Subjects()) {
    SCOPED_TRACE(subject.name);
    for (const auto& [width_px, height_px] : {std::pair{kImageWidthPx + 1, kImageHeightPx},
                                              std::pair{kImageWidthPx, kImageHeightPx - 1},
                                              std::pair{kMaxImageSidePx, kMaxImageSidePx}}) {
      const absl::Status status = subject.decode(subject.file, width_px, height_px);
      ExpectImageRefusal(status);
      EXPECT_EQ(ReasonOf(status), reason::kImageSizeMismatch) << status;
    }
  }
}

TEST(ImageDecoders, RefuseToExpectAnImpossibleSize) {
  for (const Subject& subject : Subjects()) {
    for (const auto& [width_px, height_px] :
         {std::pair{0, 5}, std::pair{5, 0}, std::pair{-1, -1}, std::pair{kMaxImageSidePx + 1, 1}}) {
      EXPECT_EQ(ReasonOf(subject.decode(subject.file, width_px, height_px)),
                reason::kImageSizeMismatch)
          << subject.name;
    }
  }
}

TEST(DecodePixels, RefusesBombsAndSparesSmallImages) {
  const std::string small(std::size_t{1024} * 1024, '\0');
  EXPECT_TRUE(DecodePixels(MakeZstd(small), PixelEncoding::kZstdUint8, 1024, 1024).ok());
  const std::string large(std::size_t{2048} * 2048, '\0');
  const absl::Status zstd =
      DecodePixels(MakeZstd(large), PixelEncoding::kZstdUint8, 2048, 2048).status();
  EXPECT_EQ(ReasonOf(zstd), reason::kBadImageEncoding) << zstd;
  const std::string png = MakePng(2048, 2048, {}, {0});
  const absl::Status bomb = DecodePixels(png, PixelEncoding::kPng, 2048, 2048).status();
  EXPECT_EQ(ReasonOf(bomb), reason::kBadImageEncoding) << bomb;
  EXPECT_TRUE(DecodePixels(MakePng(1024, 1024, {}, {0}), PixelEncoding::kPng, 1024, 1024).ok());
}

TEST(DecodePixels, RefusesZstdThatHidesOrMisstatesItsSize) {
  const std::string pixels(20, 'x');
  EXPECT_EQ(
      ReasonOf(DecodePixels(MakeZstd(pixels, false), PixelEncoding::kZstdUint8, 5, 4).status()),
      reason::kBadImageEncoding);
  EXPECT_EQ(
      ReasonOf(DecodePixels(MakeZstd(std::string(1 << 22, 'x')), PixelEncoding::kZstdUint8, 5, 4)
                   .status()),
      reason::kImageSizeMismatch);
}

TEST(DecodePixels, RefusesPngOfTheWrongKind) {
  struct Case {
    const char* name;
    std::string file;
  };

  // A chunk of unknown type is skipped. The content of an oversized chunk is not read.
  const std::string harmless = MakePngChunk("prVt", std::string(1000, 'x'));
  EXPECT_TRUE(DecodePixels(MakePng(4, 3, {}, {0}, harmless), PixelEncoding::kPng, 4, 3).ok());
  for (const Case& c :
       {Case{"interlaced", MakePng(4, 3, {.interlaced = true}, {0})},
        Case{"rgb", MakePng(4, 3, {.color_type = kPngRgb}, {0, 0, 0})},
        Case{"grey with alpha", MakePng(4, 3, {.color_type = kPngGreyAlpha}, {0, 0})},
        Case{"four bits", MakePng(4, 3, {.bit_depth = 4}, {0})},
        Case{"rows beyond the image", MakePng(4, 3, {}, {0, 0})},
        Case{"unknown critical chunk", MakePng(4, 3, {}, {0}, MakePngChunk("ABCD", "x"))},
        Case{"huge text",
             MakePng(4, 3, {}, {0}, MakePngChunk("tEXt", std::string(1 << 20, 'x')))}}) {
    const absl::Status status = DecodePixels(c.file, PixelEncoding::kPng, 4, 3).status();
    EXPECT_EQ(ReasonOf(status), reason::kBadImageEncoding) << c.name << ": " << status;
    EXPECT_EQ(FieldOf(status), "data") << c.name;
  }
}

TEST(DecodePixels, SkipsAFloodOfPngTextUnread) {
  std::string flood;
  // The content is not valid compressed text, so a decoder that decompresses it fails.
  for (int i = 0; i < 2000; ++i) flood += MakePngChunk("zTXt", std::string("k\0\0", 3) + "junk");
  EXPECT_TRUE(DecodePixels(MakePng(4, 3, {}, {0}, flood), PixelEncoding::kPng, 4, 3).ok());
}

TEST(DecodeColor, RefusesCmykJpeg) {
  const absl::Status status =
      DecodeColor(MakeJpeg({8, 8, 4, {1, 2, 3}}), ColorEncoding::kJpeg, 8, 8).status();
  EXPECT_EQ(ReasonOf(status), reason::kBadImageEncoding) << status;
}

TEST(DecodeColor, RefusesAProgressiveJpegOfEndlessScans) {
  // Each repetition of the last scan of a progressive file costs decoding time.
  const std::string file = MakeJpeg({8, 8, 1, {50, 50, 50}, true});
  const std::size_t scan = file.rfind("\xff\xda");
  const std::string last_scan = file.substr(scan, file.size() - 2 - scan);
  std::string endless = file.substr(0, file.size() - 2);
  for (int i = 0; i < 1000; ++i) endless += last_scan;
  endless += file.substr(file.size() - 2);
  const absl::Status status = DecodeColor(endless, ColorEncoding::kJpeg, 8, 8).status();
  EXPECT_EQ(ReasonOf(status), reason::kBadImageEncoding) << status;
}

}  // namespace
}  // namespace steadymap

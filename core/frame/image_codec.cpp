#include "core/frame/image_codec.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <new>
#include <vector>

#include <absl/strings/str_cat.h>
#include <zstd.h>

#include "core/frame/image_expectation.h"
#include "core/frame/jpeg_codec.h"
#include "core/frame/png_codec.h"
#include "core/frame/png_encoder.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

static_assert(std::endian::native == std::endian::little, "raw pixels are copied in memory order");

// Level 1 compresses a depth image in about 1 ms. Higher levels save only a few percent.
constexpr int kImageZstdLevel = 1;

constexpr std::size_t kOneByte = sizeof(std::uint8_t);
constexpr std::size_t kTwoBytes = sizeof(std::uint16_t);

absl::StatusOr<Image<std::uint16_t>> DecodeRaw(std::string_view data,
                                               std::size_t bytes_per_pixel,
                                               const ImageExpectation& expectation) {
  const absl::Status status = CheckPixelBytes(expectation, bytes_per_pixel, data.size());
  if (!status.ok()) return status;
  Image<std::uint16_t> image(expectation.width_px, expectation.height_px);
  if (bytes_per_pixel == kTwoBytes) {
    std::memcpy(image.data(), data.data(), data.size());
  } else {
    std::transform(data.begin(), data.end(), image.data(), [](char byte) {
      return static_cast<std::uint8_t>(byte);
    });
  }
  return image;
}

// Returns OK if `data` is exactly one zstd frame that declares the expected size.
absl::Status CheckZstdFrame(std::string_view data,
                            std::size_t bytes_per_pixel,
                            const ImageExpectation& expectation) {
  const unsigned long long declared_bytes = ZSTD_getFrameContentSize(data.data(), data.size());
  if (declared_bytes == ZSTD_CONTENTSIZE_ERROR) {
    return MalformedImage(expectation, "malformed zstd: it does not start with a zstd frame");
  }
  if (declared_bytes == ZSTD_CONTENTSIZE_UNKNOWN) {
    return MalformedImage(expectation, "a zstd frame must declare the size of its content");
  }
  absl::Status status = CheckPixelBytes(expectation, bytes_per_pixel, declared_bytes);
  if (status.ok()) status = CheckCompressionRatio(expectation, bytes_per_pixel, data.size());
  if (!status.ok()) return status;
  const std::size_t frame_bytes = ZSTD_findFrameCompressedSize(data.data(), data.size());
  if (ZSTD_isError(frame_bytes) != 0) {
    return MalformedImage(expectation,
                          absl::StrCat("malformed zstd: ", ZSTD_getErrorName(frame_bytes)));
  }
  if (frame_bytes != data.size()) {
    return MalformedImage(expectation, "malformed zstd: bytes follow the end of the frame");
  }
  return absl::OkStatus();
}

absl::StatusOr<Image<std::uint16_t>> DecodeZstd(std::string_view data,
                                                std::size_t bytes_per_pixel,
                                                const ImageExpectation& expectation) {
  const absl::Status status = CheckZstdFrame(data, bytes_per_pixel, expectation);
  if (!status.ok()) return status;
  Image<std::uint16_t> image(expectation.width_px, expectation.height_px);
  const std::size_t pixel_bytes = ExpectedBytes(expectation, bytes_per_pixel);
  std::vector<std::uint8_t> narrow(bytes_per_pixel == kOneByte ? pixel_bytes : 0);
  void* destination = narrow.empty() ? static_cast<void*>(image.data()) : narrow.data();
  const std::size_t unpacked_bytes =
      ZSTD_decompress(destination, pixel_bytes, data.data(), data.size());
  if (ZSTD_isError(unpacked_bytes) != 0) {
    return MalformedImage(expectation,
                          absl::StrCat("malformed zstd: ", ZSTD_getErrorName(unpacked_bytes)));
  }
  if (unpacked_bytes != pixel_bytes) {
    return MalformedImage(expectation,
                          "malformed zstd: the content is shorter than its declared size");
  }
  std::copy(narrow.begin(), narrow.end(), image.data());
  return image;
}

absl::StatusOr<Image<std::uint16_t>> Decode(std::string_view data,
                                            PixelEncoding encoding,
                                            const ImageExpectation& expectation,
                                            PngDepth png_depth) {
  const absl::Status status = CheckExpectedSize(expectation);
  if (!status.ok()) return status;
  switch (encoding) {
    case PixelEncoding::kRawUint8:
      return DecodeRaw(data, kOneByte, expectation);
    case PixelEncoding::kRawUint16:
      return DecodeRaw(data, kTwoBytes, expectation);
    case PixelEncoding::kPng:
      return DecodePngPixels(data, expectation, png_depth);
    case PixelEncoding::kZstdUint8:
      return DecodeZstd(data, kOneByte, expectation);
    case PixelEncoding::kZstdUint16:
      return DecodeZstd(data, kTwoBytes, expectation);
  }
  return UnsupportedPacking(expectation, "unknown pixel encoding");
}

absl::StatusOr<Image<Rgb>> DecodeRawColor(std::string_view data,
                                          const ImageExpectation& expectation) {
  const absl::Status status = CheckPixelBytes(expectation, sizeof(Rgb), data.size());
  if (!status.ok()) return status;
  Image<Rgb> image(expectation.width_px, expectation.height_px);
  std::memcpy(image.data(), data.data(), data.size());
  return image;
}

std::string NarrowedBytes(const Image<std::uint16_t>& image) {
  std::string bytes(image.size(), '\0');
  for (std::size_t i = 0; i < image.size(); ++i) {
    assert(image.data()[i] < 256);
    bytes[i] = static_cast<char>(image.data()[i]);
  }
  return bytes;
}

std::string_view WideBytes(const Image<std::uint16_t>& image) {
  return {reinterpret_cast<const char*>(image.data()), image.size() * kTwoBytes};
}

std::string PackZstd(std::string_view bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t packed_bytes =
      ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kImageZstdLevel);
  // The buffer has the worst-case size, so only a lack of memory can cause an error.
  if (ZSTD_isError(packed_bytes) != 0) throw std::bad_alloc();
  packed.resize(packed_bytes);
  return packed;
}

bool FitsInBytes(const Image<std::uint16_t>& image) {
  return std::all_of(
      image.data(), image.data() + image.size(), [](std::uint16_t pixel) { return pixel < 256; });
}

}  // namespace

absl::StatusOr<Image<std::uint16_t>> DecodePixels(std::string_view data,
                                                  PixelEncoding encoding,
                                                  int width_px,
                                                  int height_px) {
  return Decode(
      data, encoding, {width_px, height_px, reason::kBadImageEncoding}, PngDepth::k8Or16Bits);
}

absl::StatusOr<Image<std::uint16_t>> DecodeDepth(std::string_view data,
                                                 PixelEncoding encoding,
                                                 int width_px,
                                                 int height_px) {
  const ImageExpectation expectation{width_px, height_px, reason::kBadDepthEncoding};
  if (encoding == PixelEncoding::kRawUint8 || encoding == PixelEncoding::kZstdUint8) {
    return UnsupportedPacking(expectation, "depth must have 16 bits per pixel, got 8");
  }
  return Decode(data, encoding, expectation, PngDepth::k16BitsOnly);
}

absl::StatusOr<Image<Rgb>> DecodeColor(std::string_view data,
                                       ColorEncoding encoding,
                                       int width_px,
                                       int height_px) {
  const ImageExpectation expectation{width_px, height_px, reason::kBadImageEncoding};
  const absl::Status status = CheckExpectedSize(expectation);
  if (!status.ok()) return status;
  switch (encoding) {
    case ColorEncoding::kJpeg:
      return DecodeJpegColor(data, expectation);
    case ColorEncoding::kPng:
      return DecodePngColor(data, expectation);
    case ColorEncoding::kRawRgb8:
      return DecodeRawColor(data, expectation);
  }
  return UnsupportedPacking(expectation, "unknown colour encoding");
}

std::string EncodePixels(const Image<std::uint16_t>& image,
                         PixelEncoding encoding,
                         bool force_16_bits) {
  switch (encoding) {
    case PixelEncoding::kRawUint8:
      return NarrowedBytes(image);
    case PixelEncoding::kRawUint16:
      return std::string(WideBytes(image));
    case PixelEncoding::kPng:
      return EncodePngPixels(image, force_16_bits || !FitsInBytes(image));
    case PixelEncoding::kZstdUint8:
      return PackZstd(NarrowedBytes(image));
    case PixelEncoding::kZstdUint16:
      return PackZstd(WideBytes(image));
  }
  return {};
}

std::string EncodeColorPng(const Image<Rgb>& image) { return EncodePngColor(image); }

absl::StatusOr<ImageSize> PeekImageSize(std::string_view data) {
  const ImageExpectation expectation{0, 0, reason::kBadImageEncoding};
  ImageSize size;
  absl::Status status;
  if (HasPngSignature(data)) {
    status = ReadPngSize(data, expectation, &size.width_px, &size.height_px);
  } else if (HasJpegSignature(data)) {
    status = ReadJpegSize(data, expectation, &size.width_px, &size.height_px);
  } else {
    status = MalformedImage(expectation, "the data are neither a PNG nor a JPEG file");
  }
  if (!status.ok()) return status;
  return size;
}

}  // namespace steadymap

#include "client/dataset/files/tiff_file.h"

#include <array>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include <absl/strings/str_cat.h>
#include <tiffio.h>

#include "client/dataset/files/image_file.h"
#include "client/dataset/files/text_file.h"

namespace steadymap {
namespace {

// Largest single allocation of libtiff: a strip may contain the whole image, compressed and
// decompressed.
constexpr tmsize_t kMaxAllocationBytes = tmsize_t{256} << 20;

int RecordFault(TIFF* /*tiff*/,
                void* user_data,
                const char* /*module*/,
                const char* format,
                std::va_list arguments) {
  auto& fault = *static_cast<std::string*>(user_data);
  std::array<char, 200> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  if (fault.empty()) fault = text.data();
  return 1;  // Handled: libtiff must not print it.
}

int Ignore(TIFF* /*tiff*/,
           void* /*user_data*/,
           const char* /*module*/,
           const char* /*format*/,
           std::va_list /*arguments*/) {
  return 1;
}

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

struct FreeOptions {
  void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};

using OpenTiff = std::unique_ptr<TIFF, CloseTiff>;

// Opens a file; null if it is not a TIFF file. `fault` must outlive the result.
OpenTiff Open(const std::filesystem::path& file, std::string* fault) {
  const std::unique_ptr<TIFFOpenOptions, FreeOptions> options(TIFFOpenOptionsAlloc());
  if (options == nullptr) return nullptr;
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMaxAllocationBytes);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), RecordFault, fault);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), Ignore, nullptr);
  // "m" disables memory mapping: with it, a file that shrinks during reading would crash the
  // process.
  return OpenTiff(TIFFOpenExt(file.c_str(), "rm", options.get()));
}

ImageSize SizeOf(TIFF* tiff) {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
  const auto clamp = [](std::uint32_t side) {
    constexpr auto kMax = static_cast<std::uint32_t>(std::numeric_limits<int>::max());
    return static_cast<int>(side < kMax ? side : kMax);
  };
  return {clamp(width), clamp(height)};
}

bool HoldsFloats(TIFF* tiff) {
  std::uint16_t channels = 0;
  std::uint16_t bits = 0;
  std::uint16_t format = 0;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &channels);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
  return channels == 1 && bits == 32 && format == SAMPLEFORMAT_IEEEFP && TIFFIsTiled(tiff) == 0;
}

bool Decode(TIFF* tiff, Image<float>* image) {
  const auto row_bytes = static_cast<std::size_t>(image->width_px()) * sizeof(float);
  if (TIFFScanlineSize(tiff) != static_cast<tmsize_t>(row_bytes)) return false;
  for (int row = 0; row < image->height_px(); ++row) {
    if (TIFFReadScanline(tiff, &image->At(0, row), static_cast<std::uint32_t>(row), 0) != 1) {
      return false;
    }
  }
  return true;
}

}  // namespace

absl::StatusOr<Image<float>> ReadTiffFile(const std::filesystem::path& file,
                                          const PinholeCamera& camera) {
  constexpr std::string_view kExpected = "a TIFF image of one channel of 32-bit floats in strips";
  const absl::Status status = SizeOfFile(file, kMaxImageFileBytes).status();
  if (!status.ok()) return status;
  std::string fault;
  const auto found = [&fault] {
    return fault.empty() ? std::string("a file of another type") : absl::StrCat("\"", fault, "\"");
  };
  const OpenTiff tiff = Open(file, &fault);
  if (tiff == nullptr) return MalformedFile(file, kExpected, found());
  const ImageSize size = SizeOf(tiff.get());
  if (absl::Status wrong = CheckImageSize(file, camera, size); !wrong.ok()) return wrong;
  if (!HoldsFloats(tiff.get())) return MalformedFile(file, kExpected, "other pixel formats");
  Image<float> image(size.width_px, size.height_px);
  if (!Decode(tiff.get(), &image)) return MalformedFile(file, kExpected, found());
  return image;
}

}  // namespace steadymap

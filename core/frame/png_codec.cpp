#include "core/frame/png_codec.h"

#include <bit>
#include <cstring>
#include <vector>

#include <absl/strings/str_cat.h>
#include <png.h>

#include "core/frame/png_error.h"

namespace steadymap {
namespace {

static_assert(std::endian::native == std::endian::little,
              "16-bit rows are swapped unconditionally");

// Maximum length of every chunk except the image data. Sufficient for a colour profile, too small
// to exhaust memory.
constexpr png_alloc_size_t kMaxChunkBytes = png_alloc_size_t{256} * 1024;

constexpr std::size_t kSignatureBytes = 8;
// The end of the image size: signature, length and name of the first chunk, width, height.
constexpr std::size_t kSizeEnd = kSignatureBytes + 4 + 4 + 4 + 4;
constexpr std::string_view kStart("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);

struct Source {
  std::string_view left;
};

void ReadFromSource(png_structp png, png_bytep destination, std::size_t count) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (count > source->left.size()) png_error(png, "the file is truncated");
  std::memcpy(destination, source->left.data(), count);
  source->left.remove_prefix(count);
}

// A single pass over a PNG file. After an error, methods return false and `error` has the message.
class PngReader {
 public:
  explicit PngReader(std::string_view data) : source_{data} {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &trap_, OnPngError, OnPngWarning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }

  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  bool ReadHeader(const ImageExpectation& expectation) {
    if (info_ == nullptr) return false;
    return Guard(&trap_, [this, &expectation] {
      png_set_read_fn(png_, &source_, ReadFromSource);
      png_set_crc_action(png_, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
      png_set_benign_errors(png_, 0);
      png_set_user_limits(png_,
                          static_cast<png_uint_32>(expectation.width_px),
                          static_cast<png_uint_32>(expectation.height_px));
      png_set_chunk_malloc_max(png_, kMaxChunkBytes);
      png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
      png_read_info(png_, info_);
    });
  }

  int width_px() const { return static_cast<int>(png_get_image_width(png_, info_)); }

  int height_px() const { return static_cast<int>(png_get_image_height(png_, info_)); }

  int bit_depth() const { return png_get_bit_depth(png_, info_); }

  // Returns the inflated bytes per pixel; 0 below 8 bits.
  std::size_t bytes_per_pixel() const {
    return static_cast<std::size_t>(png_get_channels(png_, info_)) *
           static_cast<std::size_t>(bit_depth() / 8);
  }

  int color_type() const { return png_get_color_type(png_, info_); }

  bool interlaced() const { return png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE; }

  // Selects rows of native 8 or 16-bit integers, palette indices unexpanded.
  bool StartPixels() {
    return Guard(&trap_, [this] {
      if (png_get_bit_depth(png_, info_) == 16) png_set_swap(png_);
      png_read_update_info(png_, info_);
    });
  }

  // Selects rows of 8-bit RGB.
  bool StartColor() {
    return Guard(&trap_, [this] {
      png_set_palette_to_rgb(png_);
      png_set_scale_16(png_);
      png_set_gray_to_rgb(png_);
      png_set_strip_alpha(png_);
      png_read_update_info(png_, info_);
    });
  }

  // Returns the number of bytes that ReadRow writes.
  std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }

  bool ReadRow(void* row) {
    return Guard(&trap_, [this, row] { png_read_row(png_, static_cast<png_bytep>(row), nullptr); });
  }

  // Reads to the end of the file. Bytes after it are an error.
  bool ReadEnd() {
    return Guard(&trap_, [this] {
      png_read_end(png_, nullptr);
      if (!source_.left.empty()) png_error(png_, "bytes follow the end of the image");
    });
  }

  const char* error() const { return trap_.message.data(); }

 private:
  Source source_;
  PngErrorTrap trap_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

absl::Status BrokenPng(const ImageExpectation& expectation, const char* error) {
  return MalformedImage(expectation, absl::StrCat("malformed PNG: ", error));
}

// Checks all properties that are available before the first row: size, expansion, kind.
absl::Status OpenPng(std::string_view data,
                     const ImageExpectation& expectation,
                     PngReader* reader) {
  int width_px = 0;
  int height_px = 0;
  absl::Status status = ReadPngSize(data, expectation, &width_px, &height_px);
  if (status.ok()) status = CheckDeclaredSize(expectation, width_px, height_px);
  if (!status.ok()) return status;
  if (!reader->ReadHeader(expectation)) return BrokenPng(expectation, reader->error());
  if (reader->interlaced()) {
    return MalformedImage(expectation, "a PNG file must not be interlaced");
  }
  if (reader->bit_depth() < 8) {
    return MalformedImage(
        expectation,
        absl::StrCat("a PNG file must have 8 or 16 bits per channel, got ", reader->bit_depth()));
  }
  status = CheckDeclaredSize(expectation, reader->width_px(), reader->height_px());
  if (!status.ok()) return status;
  return CheckCompressionRatio(expectation, reader->bytes_per_pixel(), data.size());
}

absl::Status ReadRows(PngReader* reader,
                      const ImageExpectation& expectation,
                      Image<std::uint16_t>* image) {
  const auto width = static_cast<std::size_t>(expectation.width_px);
  const bool wide = reader->row_bytes() == 2 * width;
  std::vector<std::uint8_t> row(wide ? 0 : reader->row_bytes());
  for (int v = 0; v < expectation.height_px; ++v) {
    std::uint16_t* pixels = &image->At(0, v);
    if (!reader->ReadRow(wide ? static_cast<void*>(pixels) : row.data())) {
      return BrokenPng(expectation, reader->error());
    }
    for (std::size_t u = 0; u < row.size(); ++u) pixels[u] = row[u];
  }
  if (!reader->ReadEnd()) return BrokenPng(expectation, reader->error());
  return absl::OkStatus();
}

}  // namespace

bool HasPngSignature(std::string_view data) {
  return data.substr(0, kSignatureBytes) == kStart.substr(0, kSignatureBytes);
}

absl::Status ReadPngSize(std::string_view data,
                         const ImageExpectation& expectation,
                         int* width_px,
                         int* height_px) {
  if (data.size() < kSizeEnd || data.substr(0, kStart.size()) != kStart) {
    return MalformedImage(expectation, "malformed PNG: it does not start with a PNG header");
  }
  const auto* bytes = reinterpret_cast<png_const_bytep>(data.data() + kStart.size());
  const png_uint_32 width = png_get_uint_32(bytes);
  const png_uint_32 height = png_get_uint_32(bytes + 4);
  if (width == 0 || height == 0 || width > PNG_UINT_31_MAX || height > PNG_UINT_31_MAX) {
    return MalformedImage(expectation,
                          absl::StrCat("malformed PNG: declared size of ", width, " x ", height));
  }
  *width_px = static_cast<int>(width);
  *height_px = static_cast<int>(height);
  return absl::OkStatus();
}

absl::StatusOr<Image<std::uint16_t>> DecodePngPixels(std::string_view data,
                                                     const ImageExpectation& expectation,
                                                     PngDepth depth) {
  PngReader reader(data);
  absl::Status status = OpenPng(data, expectation, &reader);
  if (!status.ok()) return status;
  if (reader.color_type() != PNG_COLOR_TYPE_GRAY && reader.color_type() != PNG_COLOR_TYPE_PALETTE) {
    return MalformedImage(
        expectation,
        "a PNG file of labels, instances or depth must be greyscale or have a palette");
  }
  if (depth == PngDepth::k16BitsOnly && reader.bit_depth() != 16) {
    return MalformedImage(
        expectation,
        absl::StrCat("a depth PNG file must have 16 bits per pixel, got ", reader.bit_depth()));
  }
  if (!reader.StartPixels()) return BrokenPng(expectation, reader.error());
  const auto width = static_cast<std::size_t>(expectation.width_px);
  if (reader.row_bytes() != width * static_cast<std::size_t>(reader.bit_depth() / 8)) {
    return BrokenPng(expectation, "unexpected length of rows");
  }
  Image<std::uint16_t> image(expectation.width_px, expectation.height_px);
  status = ReadRows(&reader, expectation, &image);
  if (!status.ok()) return status;
  return image;
}

absl::StatusOr<Image<Rgb>> DecodePngColor(std::string_view data,
                                          const ImageExpectation& expectation) {
  static_assert(sizeof(Rgb) == 3);
  PngReader reader(data);
  const absl::Status status = OpenPng(data, expectation, &reader);
  if (!status.ok()) return status;
  if (!reader.StartColor()) return BrokenPng(expectation, reader.error());
  if (reader.row_bytes() != static_cast<std::size_t>(expectation.width_px) * sizeof(Rgb)) {
    return BrokenPng(expectation, "unexpected length of rows");
  }
  Image<Rgb> image(expectation.width_px, expectation.height_px);
  for (int v = 0; v < expectation.height_px; ++v) {
    if (!reader.ReadRow(&image.At(0, v))) return BrokenPng(expectation, reader.error());
  }
  if (!reader.ReadEnd()) return BrokenPng(expectation, reader.error());
  return image;
}

}  // namespace steadymap

#include "core/frame/jpeg_codec.h"

#include <array>
#include <csetjmp>
#include <cstdio>

#include <absl/strings/str_cat.h>
#include <jpeglib.h>

#include "core/frame/error_jump.h"

namespace steadymap {
namespace {

// A progressive file has about ten scans. Thousands of empty scans of a large image would take
// minutes of processor time.
constexpr int kMaxScans = 50;

// The target of libjpeg's error callbacks. All calls into libjpeg run inside `Guard`.
struct JpegErrorTrap {
  jpeg_error_mgr manager;  // First member: libjpeg returns a pointer to it.
  std::jmp_buf jump;
  std::array<char, JMSG_LENGTH_MAX> message{};
};

[[noreturn]] void OnJpegError(j_common_ptr decoder) {
  auto* trap = reinterpret_cast<JpegErrorTrap*>(decoder->err);
  trap->manager.format_message(decoder, trap->message.data());
  std::longjmp(trap->jump, 1);
}

// Level -1 is a warning of libjpeg: data were missing or corrupt, and libjpeg invented
// replacements.
void OnJpegMessage(j_common_ptr decoder, int level) {
  if (level < 0) OnJpegError(decoder);
}

void OnJpegOutput(j_common_ptr) {}

void OnJpegProgress(j_common_ptr decoder) {
  if (reinterpret_cast<j_decompress_ptr>(decoder)->input_scan_number <= kMaxScans) return;
  auto* trap = reinterpret_cast<JpegErrorTrap*>(decoder->err);
  std::snprintf(trap->message.data(), trap->message.size(), "more than %d scans", kMaxScans);
  std::longjmp(trap->jump, 1);
}

// A single pass over a JPEG file. After an error, methods return false and `error` has the message.
class JpegReader {
 public:
  JpegReader() {
    decoder_.err = jpeg_std_error(&trap_.manager);
    trap_.manager.error_exit = OnJpegError;
    trap_.manager.emit_message = OnJpegMessage;
    trap_.manager.output_message = OnJpegOutput;
    progress_.progress_monitor = OnJpegProgress;
  }

  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  ~JpegReader() { jpeg_destroy_decompress(&decoder_); }

  bool ReadHeader(std::string_view data) {
    return Guard(&trap_, [this, data] {
      jpeg_create_decompress(&decoder_);
      decoder_.progress = &progress_;
      jpeg_mem_src(&decoder_, reinterpret_cast<const unsigned char*>(data.data()), data.size());
      jpeg_read_header(&decoder_, TRUE);
    });
  }

  int width_px() const { return static_cast<int>(decoder_.image_width); }

  int height_px() const { return static_cast<int>(decoder_.image_height); }

  // True if libjpeg can convert the file to RGB and it has no arithmetic coding.
  bool supported() const {
    const J_COLOR_SPACE space = decoder_.jpeg_color_space;
    return decoder_.arith_code == FALSE &&
           (space == JCS_YCbCr || space == JCS_RGB || space == JCS_GRAYSCALE);
  }

  bool StartColor() {
    return Guard(&trap_, [this] {
      decoder_.out_color_space = JCS_RGB;
      jpeg_start_decompress(&decoder_);
    });
  }

  std::size_t row_bytes() const {
    return static_cast<std::size_t>(decoder_.output_width) *
           static_cast<std::size_t>(decoder_.output_components);
  }

  bool ReadRow(void* row) {
    return Guard(&trap_, [this, row] {
      auto* samples = static_cast<JSAMPROW>(row);
      jpeg_read_scanlines(&decoder_, &samples, 1);
    });
  }

  bool ReadEnd() {
    return Guard(&trap_, [this] { jpeg_finish_decompress(&decoder_); });
  }

  // Returns the number of bytes after the end of the image. Valid after ReadEnd.
  std::size_t bytes_left() const { return decoder_.src->bytes_in_buffer; }

  const char* error() const { return trap_.message.data(); }

 private:
  JpegErrorTrap trap_{};
  jpeg_progress_mgr progress_{};
  jpeg_decompress_struct decoder_{};
};

absl::Status BrokenJpeg(const ImageExpectation& expectation, const char* error) {
  return MalformedImage(expectation, absl::StrCat("malformed JPEG: ", error));
}

}  // namespace

bool HasJpegSignature(std::string_view data) { return data.substr(0, 3) == "\xff\xd8\xff"; }

absl::Status ReadJpegSize(std::string_view data,
                          const ImageExpectation& expectation,
                          int* width_px,
                          int* height_px) {
  JpegReader reader;
  if (!reader.ReadHeader(data)) return BrokenJpeg(expectation, reader.error());
  *width_px = reader.width_px();
  *height_px = reader.height_px();
  return absl::OkStatus();
}

absl::StatusOr<Image<Rgb>> DecodeJpegColor(std::string_view data,
                                           const ImageExpectation& expectation) {
  static_assert(sizeof(Rgb) == 3);
  JpegReader reader;
  if (!reader.ReadHeader(data)) return BrokenJpeg(expectation, reader.error());
  absl::Status status = CheckDeclaredSize(expectation, reader.width_px(), reader.height_px());
  if (status.ok()) status = CheckCompressionRatio(expectation, sizeof(Rgb), data.size());
  if (!status.ok()) return status;
  if (!reader.supported()) {
    return MalformedImage(expectation,
                          "a JPEG file must be RGB, YCbCr or grey, without arithmetic coding");
  }
  if (!reader.StartColor()) return BrokenJpeg(expectation, reader.error());
  if (reader.row_bytes() != static_cast<std::size_t>(expectation.width_px) * sizeof(Rgb)) {
    return BrokenJpeg(expectation, "unexpected length of rows");
  }
  Image<Rgb> image(expectation.width_px, expectation.height_px);
  for (int v = 0; v < expectation.height_px; ++v) {
    if (!reader.ReadRow(&image.At(0, v))) return BrokenJpeg(expectation, reader.error());
  }
  if (!reader.ReadEnd()) return BrokenJpeg(expectation, reader.error());
  if (reader.bytes_left() != 0) {
    return BrokenJpeg(expectation, "bytes follow the end of the image");
  }
  return image;
}

}  // namespace steadymap

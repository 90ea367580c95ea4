#include "client/dataset/files/exr_file.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <OpenEXR/openexr.h>
#include <absl/strings/str_cat.h>

#include "client/dataset/files/image_file.h"
#include "client/dataset/files/text_file.h"

namespace steadymap {
namespace {

constexpr int kPart = 0;
// Far more than a depth image needs. A chunk is decoded with all of its channels.
constexpr int kMaxChannels = 16;

// The input of OpenEXR, and the first error that it reported.
struct ExrInput {
  std::string data;
  std::string fault;
};

std::int64_t ReadBytes(exr_const_context_t /*context*/,
                       void* user_data,
                       void* buffer,
                       std::uint64_t size_bytes,
                       std::uint64_t offset_bytes,
                       exr_stream_error_func_ptr_t /*on_error*/) {
  const std::string& data = static_cast<const ExrInput*>(user_data)->data;
  if (offset_bytes > data.size()) return -1;
  const std::uint64_t count = std::min<std::uint64_t>(size_bytes, data.size() - offset_bytes);
  if (count > 0) std::memcpy(buffer, data.data() + offset_bytes, count);
  return static_cast<std::int64_t>(count);
}

std::int64_t CountBytes(exr_const_context_t /*context*/, void* user_data) {
  return static_cast<std::int64_t>(static_cast<const ExrInput*>(user_data)->data.size());
}

void RecordFault(exr_const_context_t context, exr_result_t code, const char* message) {
  void* user_data = nullptr;
  if (context == nullptr || exr_get_user_data(context, &user_data) != EXR_ERR_SUCCESS) return;
  if (user_data == nullptr) return;
  std::string& fault = static_cast<ExrInput*>(user_data)->fault;
  if (fault.empty()) fault = message != nullptr ? message : exr_get_default_error_message(code);
}

// An open file; closed by the destructor.
class ExrReader {
 public:
  explicit ExrReader(std::string data) { input_.data = std::move(data); }

  ~ExrReader() {
    if (is_decoding_) exr_decoding_destroy(context_, &decoder_);
    if (context_ != nullptr) exr_finish(&context_);
  }

  ExrReader(const ExrReader&) = delete;
  ExrReader& operator=(const ExrReader&) = delete;

  // Each returns false or none on failure; `fault` may then contain the reason.
  bool Open(const std::filesystem::path& file);
  std::optional<ImageSize> size() const;
  bool ChooseChannel();
  bool Decode(Image<float>* image);

  std::string fault() const {
    return input_.fault.empty() ? "a damaged file" : absl::StrCat("\"", input_.fault, "\"");
  }

 private:
  bool DecodeChunk(int first_row, Image<float>* image);

  ExrInput input_;
  exr_context_t context_ = nullptr;
  exr_decode_pipeline_t decoder_ = {};
  bool is_decoding_ = false;
  std::string channel_;
  std::vector<float> ignored_;  // Decoded chunk of the channels that are not used.
  int top_ = 0;                 // First row of the data window.
};

bool ExrReader::Open(const std::filesystem::path& file) {
  exr_context_initializer_t options = {};
  options.size = sizeof(options);
  options.error_handler_fn = RecordFault;
  options.user_data = &input_;
  options.read_fn = ReadBytes;
  options.size_fn = CountBytes;
  options.max_image_width = kMaxImageSidePx;
  options.max_image_height = kMaxImageSidePx;
  options.max_tile_width = kMaxImageSidePx;
  options.max_tile_height = kMaxImageSidePx;
  options.zip_level = -1;
  options.dwa_quality = -1.0F;
  exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
  exr_attr_box2i_t window = {};
  if (exr_start_read(&context_, file.c_str(), &options) != EXR_ERR_SUCCESS ||
      exr_get_storage(context_, kPart, &storage) != EXR_ERR_SUCCESS ||
      exr_get_data_window(context_, kPart, &window) != EXR_ERR_SUCCESS) {
    return false;
  }
  if (storage != EXR_STORAGE_SCANLINE) input_.fault = "tiles or deep data";
  top_ = window.min.y;
  return storage == EXR_STORAGE_SCANLINE;
}

std::optional<ImageSize> ExrReader::size() const {
  exr_attr_box2i_t window = {};
  if (exr_get_data_window(context_, kPart, &window) != EXR_ERR_SUCCESS) return std::nullopt;
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || width > kMaxImageSidePx || height < 1 || height > kMaxImageSidePx) {
    return std::nullopt;
  }
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

bool ExrReader::ChooseChannel() {
  const exr_attr_chlist_t* channels = nullptr;
  if (exr_get_channels(context_, kPart, &channels) != EXR_ERR_SUCCESS) return false;
  if (channels->num_channels < 1 || channels->num_channels > kMaxChannels) {
    input_.fault = absl::StrCat(channels->num_channels, " channels");
    return false;
  }
  const exr_attr_chlist_entry_t* const end = channels->entries + channels->num_channels;
  const auto find = [&](std::string_view name) {
    return std::find_if(channels->entries, end, [name](const exr_attr_chlist_entry_t& entry) {
      return name == entry.name.str;
    });
  };
  const exr_attr_chlist_entry_t* chosen = end;
  for (const char* name : {"Z", "Y", "V", "R"}) {
    if (chosen == end) chosen = find(name);
  }
  if (chosen == end) {
    chosen = std::find_if(channels->entries, end, [](const exr_attr_chlist_entry_t& entry) {
      return std::string_view(entry.name.str) != "A";
    });
  }
  if (chosen == end || chosen->pixel_type == EXR_PIXEL_UINT || chosen->x_sampling != 1 ||
      chosen->y_sampling != 1) {
    input_.fault = "no floating-point channel with one value per pixel";
    return false;
  }
  channel_ = chosen->name.str;
  return true;
}

bool ExrReader::DecodeChunk(int first_row, Image<float>* image) {
  exr_chunk_info_t chunk = {};
  if (exr_read_scanline_chunk_info(context_, kPart, top_ + first_row, &chunk) != EXR_ERR_SUCCESS) {
    return false;
  }
  const exr_result_t begun = is_decoding_
                                 ? exr_decoding_update(context_, kPart, &chunk, &decoder_)
                                 : exr_decoding_initialize(context_, kPart, &chunk, &decoder_);
  const bool is_first = !is_decoding_;
  is_decoding_ = true;
  if (begun != EXR_ERR_SUCCESS || chunk.width != image->width_px() || chunk.height < 1 ||
      chunk.height > image->height_px() - first_row) {
    return false;
  }
  // OpenEXR's faster decoders need an output buffer for every channel.
  ignored_.resize(static_cast<std::size_t>(image->width_px()) *
                  static_cast<std::size_t>(chunk.height));
  for (int i = 0; i < decoder_.channel_count; ++i) {
    exr_coding_channel_info_t& channel = decoder_.channels[i];
    float* const place =
        channel_ == channel.channel_name ? &image->At(0, first_row) : ignored_.data();
    channel.decode_to_ptr = reinterpret_cast<std::uint8_t*>(place);
    channel.user_bytes_per_element = sizeof(float);
    channel.user_data_type = channel.data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
    channel.user_pixel_stride = sizeof(float);
    channel.user_line_stride = image->width_px() * static_cast<std::int32_t>(sizeof(float));
  }
  if (is_first && exr_decoding_choose_default_routines(context_, kPart, &decoder_) != 0) {
    return false;
  }
  return exr_decoding_run(context_, kPart, &decoder_) == EXR_ERR_SUCCESS;
}

bool ExrReader::Decode(Image<float>* image) {
  std::int32_t chunk_rows = 0;
  if (exr_get_scanlines_per_chunk(context_, kPart, &chunk_rows) != EXR_ERR_SUCCESS) return false;
  if (chunk_rows < 1) return false;
  for (int row = 0; row < image->height_px(); row += chunk_rows) {
    if (!DecodeChunk(row, image)) return false;
  }
  return true;
}

}  // namespace

absl::StatusOr<Image<float>> ReadExrFile(const std::filesystem::path& file,
                                         const PinholeCamera& camera) {
  constexpr std::string_view kExpected = "an OpenEXR image of floats in scan lines";
  absl::StatusOr<std::string> data = ReadFile(file, kMaxImageFileBytes);
  if (!data.ok()) return data.status();
  ExrReader reader(*std::move(data));
  if (!reader.Open(file)) return MalformedFile(file, kExpected, reader.fault());
  const std::optional<ImageSize> size = reader.size();
  if (!size) return MalformedFile(file, kExpected, "no image size");
  if (absl::Status status = CheckImageSize(file, camera, *size); !status.ok()) return status;
  if (!reader.ChooseChannel()) return MalformedFile(file, kExpected, reader.fault());
  Image<float> image(size->width_px, size->height_px);
  if (!reader.Decode(&image)) return MalformedFile(file, kExpected, reader.fault());
  return image;
}

}  // namespace steadymap

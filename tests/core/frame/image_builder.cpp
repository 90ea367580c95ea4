#include "tests/core/frame/image_builder.h"

#include <cstdio>
#include <cstdlib>

#include <jpeglib.h>
#include <zlib.h>
#include <zstd.h>

namespace steadymap {
namespace {

std::string BigEndian(std::uint32_t value) {
  std::string bytes;
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>((value >> shift) & 0xff);
  return bytes;
}

}  // namespace

Image<std::uint16_t> RandomPixels(int width_px, int height_px, int highest, std::mt19937* random) {
  Image<std::uint16_t> image(width_px, height_px);
  std::uniform_int_distribution<int> pixel(0, highest);
  for (std::size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<std::uint16_t>(pixel(*random));
  }
  return image;
}

Image<Rgb> RandomColors(int width_px, int height_px, std::mt19937* random) {
  Image<Rgb> image(width_px, height_px);
  std::uniform_int_distribution<int> channel(0, 255);
  for (std::size_t i = 0; i < image.size(); ++i) {
    for (std::uint8_t& value : image.data()[i]) value = static_cast<std::uint8_t>(channel(*random));
  }
  return image;
}

std::string MakePngChunk(std::string_view name, std::string_view content) {
  std::string checked(name);
  checked += content;
  const auto checksum = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size())));
  return BigEndian(static_cast<std::uint32_t>(content.size())) + checked + BigEndian(checksum);
}

std::string MakePng(int width_px,
                    int height_px,
                    const PngKind& kind,
                    const std::vector<std::uint8_t>& pixel,
                    std::string_view extra_chunks) {
  std::string rows;
  for (int v = 0; v < height_px; ++v) {
    rows += '\0';
    for (int u = 0; u < width_px; ++u) rows.append(pixel.begin(), pixel.end());
  }
  uLongf packed_bytes = compressBound(static_cast<uLong>(rows.size()));
  std::string packed(packed_bytes, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()),
           &packed_bytes,
           reinterpret_cast<const Bytef*>(rows.data()),
           static_cast<uLong>(rows.size()));
  packed.resize(packed_bytes);

  std::string header = BigEndian(static_cast<std::uint32_t>(width_px)) +
                       BigEndian(static_cast<std::uint32_t>(height_px));
  header += static_cast<char>(kind.bit_depth);
  header += static_cast<char>(kind.color_type);
  header += std::string(2, '\0');
  header += static_cast<char>(kind.interlaced);

  std::string file = "\x89PNG\r\n\x1a\n" + MakePngChunk("IHDR", header);
  file += extra_chunks;
  if (kind.color_type == kPngPalette) {
    std::string palette;
    for (const int i : {0, 1, 2, 3}) {
      for (const int base : {100, 150, 200}) palette += static_cast<char>(base + i);
    }
    file += MakePngChunk("PLTE", palette);
  }
  return file + MakePngChunk("IDAT", packed) + MakePngChunk("IEND", {});
}

std::string MakeJpeg(const JpegKind& kind) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* bytes = nullptr;
  unsigned long byte_count = 0;
  jpeg_mem_dest(&encoder, &bytes, &byte_count);
  encoder.image_width = static_cast<JDIMENSION>(kind.width_px);
  encoder.image_height = static_cast<JDIMENSION>(kind.height_px);
  encoder.input_components = kind.channels;
  encoder.in_color_space = kind.channels == 1   ? JCS_GRAYSCALE
                           : kind.channels == 3 ? JCS_RGB
                                                : JCS_CMYK;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, 95, TRUE);
  if (kind.progressive) jpeg_simple_progression(&encoder);
  jpeg_start_compress(&encoder, TRUE);
  std::vector<JSAMPLE> row;
  for (int u = 0; u < kind.width_px; ++u) {
    for (int channel = 0; channel < kind.channels; ++channel) {
      row.push_back(kind.color[static_cast<std::size_t>(channel) % 3]);
    }
  }
  JSAMPROW rows[] = {row.data()};
  for (int v = 0; v < kind.height_px; ++v) jpeg_write_scanlines(&encoder, rows, 1);
  jpeg_finish_compress(&encoder);
  std::string file(reinterpret_cast<const char*>(bytes), byte_count);
  jpeg_destroy_compress(&encoder);
  std::free(bytes);
  return file;
}

std::string MakeZstd(std::string_view content, bool declares_size) {
  std::string packed(ZSTD_compressBound(content.size()), '\0');
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, declares_size ? 1 : 0);
  packed.resize(
      ZSTD_compress2(context, packed.data(), packed.size(), content.data(), content.size()));
  ZSTD_freeCCtx(context);
  return packed;
}

}  // namespace steadymap

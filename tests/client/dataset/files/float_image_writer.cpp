#include "tests/client/dataset/files/float_image_writer.h"

#include <cstddef>
#include <cstdint>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>
#include <tiffio.h>

namespace steadymap {
namespace {

template <typename Pixel>
void WriteExrAs(const std::filesystem::path& file,
                const Image<float>& image,
                const std::string& channel,
                const ExrLayout& layout,
                Imf::PixelType type) {
  std::filesystem::create_directories(file.parent_path());
  std::vector<Pixel> pixels(image.data(), image.data() + image.size());
  std::vector<Pixel> others(image.size(), Pixel(-1.0F));
  Imf::Header header(image.width_px(), image.height_px());
  Imf::FrameBuffer buffer;
  const std::size_t row_bytes = sizeof(Pixel) * static_cast<std::size_t>(image.width_px());
  for (const std::string& name : layout.channels) {
    header.channels().insert(name, Imf::Channel(type));
    Pixel* const data = name == channel ? pixels.data() : others.data();
    buffer.insert(name, Imf::Slice(type, reinterpret_cast<char*>(data), sizeof(Pixel), row_bytes));
  }
  if (layout.is_tiled) {
    header.setTileDescription(Imf::TileDescription(16, 16));
    Imf::TiledOutputFile output(file.c_str(), header, 0);
    output.setFrameBuffer(buffer);
    output.writeTiles(0, output.numXTiles() - 1, 0, output.numYTiles() - 1);
  } else {
    Imf::OutputFile output(file.c_str(), header, 0);
    output.setFrameBuffer(buffer);
    output.writePixels(image.height_px());
  }
}

}  // namespace

void WriteExr(const std::filesystem::path& file,
              const Image<float>& image,
              const std::string& channel,
              const ExrLayout& layout) {
  if (layout.is_half) {
    WriteExrAs<half>(file, image, channel, layout, Imf::HALF);
  } else {
    WriteExrAs<float>(file, image, channel, layout, Imf::FLOAT);
  }
}

void WriteTiff(const std::filesystem::path& file, const Image<float>& image, bool is_compressed) {
  std::filesystem::create_directories(file.parent_path());
  TIFF* const tiff = TIFFOpen(file.c_str(), "w");
  ASSERT_NE(tiff, nullptr);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(image.width_px()));
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(image.height_px()));
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
  const int compression = is_compressed ? COMPRESSION_ADOBE_DEFLATE : COMPRESSION_NONE;
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
  Image<float> rows = image;
  for (int row = 0; row < rows.height_px(); ++row) {
    EXPECT_EQ(TIFFWriteScanline(tiff, &rows.At(0, row), static_cast<std::uint32_t>(row), 0), 1);
  }
  TIFFClose(tiff);
}

}  // namespace steadymap

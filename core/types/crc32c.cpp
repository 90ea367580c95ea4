#include "core/types/crc32c.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

namespace steadymap {
namespace {

// The Castagnoli polynomial, bits reversed (RFC 3720, appendix B.4).
constexpr std::uint32_t kReversedPolynomial = 0x82F63B78U;

constexpr std::size_t kSlices = 8;

using CrcTable = std::array<std::array<std::uint32_t, 256>, kSlices>;

// Row k contains the effect of a byte that is followed by k further bytes. The lookups of eight
// bytes are therefore independent of each other.
constexpr CrcTable MakeTable() {
  CrcTable table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1) ^ ((crc & 1U) != 0 ? kReversedPolynomial : 0U);
    }
    table[0][byte] = crc;
  }
  for (std::size_t slice = 1; slice < kSlices; ++slice) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = table[slice - 1][byte];
      table[slice][byte] = (before >> 8) ^ table[0][before & 0xFFU];
    }
  }
  return table;
}

constexpr CrcTable kTable = MakeTable();

std::uint32_t ExtendByEight(std::uint32_t crc, const char* bytes) {
  static_assert(std::endian::native == std::endian::little);
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, sizeof(word));
  word ^= crc;
  std::uint32_t next = 0;
  for (std::size_t slice = 0; slice < kSlices; ++slice) {
    next ^= kTable[kSlices - 1 - slice][(word >> (8 * slice)) & 0xFFU];
  }
  return next;
}

}  // namespace

std::uint32_t ExtendCrc32c(std::uint32_t crc, std::string_view data) {
  crc = ~crc;
  while (data.size() >= kSlices) {
    crc = ExtendByEight(crc, data.data());
    data.remove_prefix(kSlices);
  }
  for (const char byte : data) {
    crc = (crc >> 8) ^ kTable[0][(crc ^ static_cast<unsigned char>(byte)) & 0xFFU];
  }
  return ~crc;
}

}  // namespace steadymap

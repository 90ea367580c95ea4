#include "core/types/crc32c.h"

#include <random>
#include <string>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

// Computes CRC-32C bit by bit, directly from the definition.
std::uint32_t SlowCrc32c(const std::string& data) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char byte : data) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0x82F63B78U : 0U);
  }
  return ~crc;
}

std::string RandomBytes(std::size_t size, std::mt19937* random) {
  std::string data(size, '\0');
  for (char& byte : data) byte = static_cast<char>((*random)());
  return data;
}

TEST(ExtendCrc32c, PublishedVectors) {
  // RFC 3720, appendix B.4, and the standard check value.
  EXPECT_EQ(ExtendCrc32c(0, "123456789"), 0xE3069283U);
  EXPECT_EQ(ExtendCrc32c(0, std::string(32, '\0')), 0x8A9136AAU);
  EXPECT_EQ(ExtendCrc32c(0, std::string(32, '\xFF')), 0x62A8AB43U);
}

TEST(ExtendCrc32c, NothingLeavesTheSumAsItIs) {
  EXPECT_EQ(ExtendCrc32c(0, ""), 0U);
  EXPECT_EQ(ExtendCrc32c(0xE3069283U, ""), 0xE3069283U);
}

TEST(ExtendCrc32c, EveryLengthAgreesWithTheDefinition) {
  std::mt19937 random(1);
  for (std::size_t size = 0; size < 70; ++size) {
    const std::string data = RandomBytes(size, &random);
    EXPECT_EQ(ExtendCrc32c(0, data), SlowCrc32c(data)) << size << " bytes";
  }
}

TEST(ExtendCrc32c, PiecesGiveTheSumOfTheWhole) {
  std::mt19937 random(2);
  const std::string data = RandomBytes(1000, &random);
  for (std::size_t cut = 0; cut <= data.size(); cut += 37) {
    EXPECT_EQ(ExtendCrc32c(ExtendCrc32c(0, data.substr(0, cut)), data.substr(cut)),
              ExtendCrc32c(0, data));
  }
}

}  // namespace
}  // namespace steadymap

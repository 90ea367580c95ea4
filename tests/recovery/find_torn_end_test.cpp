#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/crc32c.h"
#include "server/store/disk/wal_repair.h"

namespace steadymap {
namespace {

constexpr std::size_t kBlockBytes = 32768;
constexpr std::size_t kHeaderBytes = 7;

/// Writes a log in RocksDB's documented format.
class LogBuilder {
 public:
  /// Adds a record; returns its start.
  std::size_t Add(const std::string& record) {
    const std::size_t start = log_.size();
    std::size_t done = 0;
    bool first = true;
    do {
      const std::size_t left = kBlockBytes - log_.size() % kBlockBytes;
      if (left < kHeaderBytes) {
        log_.append(left, '\0');
        continue;
      }
      const std::size_t length = std::min(left - kHeaderBytes, record.size() - done);
      const bool last = done + length == record.size();
      AddFragment(first ? (last ? 1 : 2) : (last ? 4 : 3), record.substr(done, length));
      done += length;
      first = false;
    } while (done < record.size());
    return start;
  }

  const std::string& log() const { return log_; }

 private:
  void AddFragment(int type, const std::string& data) {
    const std::string covered = static_cast<char>(type) + data;
    const std::uint32_t crc = ExtendCrc32c(0, covered);
    const std::uint32_t masked = ((crc >> 15) | (crc << 17)) + 0xA282EAD8U;
    for (int i = 0; i < 4; ++i) log_ += static_cast<char>((masked >> (8 * i)) & 0xFFU);
    log_ += static_cast<char>(data.size() & 0xFFU);
    log_ += static_cast<char>(data.size() >> 8);
    log_ += covered;
  }

  std::string log_;
};

std::string Noise(std::size_t bytes, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::string noise(bytes, '\0');
  for (char& byte : noise) byte = static_cast<char>(random() | 1U);
  return noise;
}

std::string WithZeros(std::string log, std::size_t begin, std::size_t end) {
  std::fill(log.begin() + static_cast<std::ptrdiff_t>(begin),
            log.begin() + static_cast<std::ptrdiff_t>(std::min(end, log.size())),
            '\0');
  return log;
}

class FindTornEndTest : public ::testing::Test {
 protected:
  FindTornEndTest() {
    for (std::uint32_t i = 0; i < 12; ++i)
      starts_.push_back(builder_.Add(Noise(std::size_t{3001} * i, i)));
  }

  LogBuilder builder_;
  std::vector<std::size_t> starts_;
};

TEST_F(FindTornEndTest, WholeAndTruncatedLogsAreNotCut) {
  EXPECT_FALSE(FindTornEnd(""));
  EXPECT_FALSE(FindTornEnd(builder_.log()));
  for (std::size_t length = 0; length < builder_.log().size(); length += 997) {
    EXPECT_FALSE(FindTornEnd(builder_.log().substr(0, length))) << length;
  }
}

TEST_F(FindTornEndTest, LastRecordThatLacksASectorIsCut) {
  for (std::size_t begin = starts_.back(); begin < builder_.log().size();
       begin = (begin / 512 + 1) * 512) {
    const std::string log = WithZeros(builder_.log(), begin, (begin / 512 + 1) * 512);
    EXPECT_EQ(FindTornEnd(log), starts_.back()) << begin;
    EXPECT_EQ(FindTornEnd(WithZeros(builder_.log(), begin, log.size())), starts_.back()) << begin;
  }
}

TEST_F(FindTornEndTest, DamageThatALaterRecordFollowsIsLeftAlone) {
  for (std::size_t begin = 0; begin < starts_.back(); begin += 512) {
    const std::string log = WithZeros(builder_.log(), begin, begin + 512);
    if (log == builder_.log() || begin + 512 > starts_.back()) continue;
    EXPECT_FALSE(FindTornEnd(log)) << begin;
  }
}

TEST_F(FindTornEndTest, FlippedBitInTheLastRecordIsLeftAlone) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    std::string log = builder_.log();
    const std::size_t place = starts_.back() + random() % (log.size() - starts_.back());
    log[place] = static_cast<char>(log[place] ^ (1 << (random() % 8)));
    EXPECT_FALSE(FindTornEnd(log)) << place;
  }
}

TEST_F(FindTornEndTest, GarbageIsLeftAlone) {
  EXPECT_FALSE(FindTornEnd(Noise(100'000, 3)));
  for (std::size_t length = 1; length < 20; ++length) EXPECT_FALSE(FindTornEnd(Noise(length, 4)));
}

}  // namespace
}  // namespace steadymap

#include "server/store/disk/wal_repair.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "core/types/crc32c.h"
#include "core/types/error.h"
#include "server/store/disk/torn_tail_write.h"

namespace steadymap {
namespace {

// RocksDB's log format: blocks, each filled with fragments; a fragment is u32 masked CRC-32C over
// type and data, u16 length of the data, u8 type, data. Remaining bytes of a block that are too few
// for a header are padding.
constexpr std::uint64_t kBlockBytes = 32768;
constexpr std::uint64_t kHeaderBytes = 7;
constexpr std::uint32_t kMaskDelta = 0xA282EAD8U;

enum class FragmentType : unsigned char { kFull = 1, kFirst = 2, kMiddle = 3, kLast = 4 };

struct Fragment {
  FragmentType type = FragmentType::kFull;
  std::uint64_t end = 0;  ///< Offset of the end of its data.
};

std::uint64_t ReadLittleEndian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i > 0; --i) {
    value = (value << 8) | static_cast<unsigned char>(bytes[i - 1]);
  }
  return value;
}

std::uint64_t BlockEnd(std::string_view log, std::uint64_t place) {
  return std::min<std::uint64_t>(log.size(), (place / kBlockBytes + 1) * kBlockBytes);
}

// Returns the intact fragment at `place`; none if there is no intact fragment.
std::optional<Fragment> ReadFragment(std::string_view log, std::uint64_t place) {
  const std::uint64_t block_end = BlockEnd(log, place);
  if (place + kHeaderBytes > block_end) return std::nullopt;
  const std::uint64_t length = ReadLittleEndian(log.substr(place + 4, 2));
  const auto type = static_cast<unsigned char>(log[place + 6]);
  const std::uint64_t end = place + kHeaderBytes + length;
  if (type < 1 || type > 4 || end > block_end) return std::nullopt;
  const auto stored = static_cast<std::uint32_t>(ReadLittleEndian(log.substr(place, 4)));
  const std::uint32_t crc = ExtendCrc32c(0, log.substr(place + 6, 1 + length));
  if (stored != ((crc >> 15) | (crc << 17)) + kMaskDelta) return std::nullopt;
  return Fragment{static_cast<FragmentType>(type), end};
}

// True if an intact fragment after `place` begins a record. After damage, the offsets of fragments
// are known again only from the next block on, so every offset in the rest of this block is tried.
bool RecordBeginsBehind(std::string_view log, std::uint64_t place) {
  const auto begins = [](const std::optional<Fragment>& fragment) {
    return fragment &&
           (fragment->type == FragmentType::kFull || fragment->type == FragmentType::kFirst);
  };
  const std::uint64_t block_end = BlockEnd(log, place);
  for (++place; place < block_end; ++place) {
    if (begins(ReadFragment(log, place))) return true;
  }
  while (place < log.size()) {
    const std::optional<Fragment> fragment = ReadFragment(log, place);
    if (begins(fragment)) return true;
    const std::uint64_t next_block = (place / kBlockBytes + 1) * kBlockBytes;
    place = fragment && fragment->end + kHeaderBytes <= next_block ? fragment->end : next_block;
  }
  return false;
}

std::optional<std::filesystem::path> FindNewestLog(const std::filesystem::path& folder) {
  std::optional<std::filesystem::path> newest;
  std::uint64_t newest_number = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() != ".log") continue;
    const std::string stem = entry.path().stem().string();
    std::uint64_t number = 0;
    std::from_chars(stem.data(), stem.data() + stem.size(), number);
    if (newest && number <= newest_number) continue;
    newest = entry.path();
    newest_number = number;
  }
  return newest;
}

absl::Status Failed(const char* what, const std::filesystem::path& file) {
  return MakeError(absl::StatusCode::kInternal,
                   reason::kInternal,
                   absl::StrCat("cannot ", what, " write-ahead log ", file.string()));
}

}  // namespace

std::optional<std::uint64_t> FindTornEnd(std::string_view log) {
  std::uint64_t place = 0;
  std::uint64_t whole_end = 0;  // End of the last complete record.
  bool within_record = false;
  while (place < log.size()) {
    const std::uint64_t block_end = (place / kBlockBytes + 1) * kBlockBytes;
    if (place + kHeaderBytes > block_end) {
      place = block_end;
      continue;
    }
    const std::optional<Fragment> fragment = ReadFragment(log, place);
    const bool begins = fragment && (fragment->type == FragmentType::kFull ||
                                     fragment->type == FragmentType::kFirst);
    if (!fragment || begins == within_record) {
      const bool torn = !RecordBeginsBehind(log, place) && HasZeroSector(log, whole_end);
      return torn ? std::optional(whole_end) : std::nullopt;
    }
    place = fragment->end;
    within_record =
        fragment->type == FragmentType::kFirst || fragment->type == FragmentType::kMiddle;
    if (!within_record) whole_end = place;
  }
  return std::nullopt;
}

absl::StatusOr<std::optional<TornLog>> FindTornLog(const std::filesystem::path& folder) {
  const std::optional<std::filesystem::path> file = FindNewestLog(folder);
  if (!file) return std::nullopt;
  std::ifstream stream(*file, std::ios::binary);
  const std::string log((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (!stream.is_open() || stream.bad()) return Failed("read", *file);
  const std::optional<std::uint64_t> end = FindTornEnd(log);
  if (!end) return std::nullopt;
  return TornLog{*file, log.size(), *end};
}

absl::Status CutTornLog(const std::filesystem::path& folder) {
  const absl::StatusOr<std::optional<TornLog>> torn = FindTornLog(folder);
  if (!torn.ok()) return torn.status();
  if (!*torn) return absl::OkStatus();
  const TornLog& log = **torn;
  const int descriptor = ::open(log.file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return Failed("open", log.file);
  const bool cut =
      ::ftruncate(descriptor, static_cast<off_t>(log.whole_end)) == 0 && ::fsync(descriptor) == 0;
  ::close(descriptor);
  if (!cut) return Failed("truncate", log.file);
  spdlog::warn("dropped {} bytes of a write that a power cut interrupted before it was durable: {}",
               log.size - log.whole_end,
               log.file.string());
  return absl::OkStatus();
}

}  // namespace steadymap

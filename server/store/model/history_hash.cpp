#include "server/store/model/history_hash.h"

#include <cstddef>
#include <string>

#include "core/types/crc32c.h"

namespace steadymap {

std::uint64_t ExtendHash(std::uint64_t hash, std::string_view bytes) {
  constexpr std::uint64_t kPrime = 0x100000001B3ULL;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * kPrime;
  return hash;
}

std::uint64_t ExtendHistory(std::uint64_t before, Revision revision, std::string_view change) {
  // A commit may write megabytes, so only the checksum and the size of its bytes are hashed.
  std::string summary;
  for (const std::uint64_t number :
       {before, revision.value(), std::uint64_t{ExtendCrc32c(0, change)}, change.size()}) {
    for (std::size_t i = 0; i < sizeof(number); ++i) {
      summary.push_back(static_cast<char>(number >> (8 * i)));
    }
  }
  return ExtendHash(kEmptyHash, summary);
}

}  // namespace steadymap

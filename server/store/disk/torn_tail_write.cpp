#include "server/store/disk/torn_tail_write.h"

#include <algorithm>

namespace steadymap {
namespace {

constexpr std::uint64_t kSectorBytes = 512;

}  // namespace

bool HasZeroSector(std::string_view file, std::uint64_t begin) {
  while (begin < file.size()) {
    const std::uint64_t end =
        std::min<std::uint64_t>(file.size(), (begin / kSectorBytes + 1) * kSectorBytes);
    if (file.substr(begin, end - begin).find_first_not_of('\0') == std::string_view::npos) {
      return true;
    }
    begin = end;
  }
  return false;
}

}  // namespace steadymap

#include "server/process/descriptors.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>

#include <sys/resource.h>

namespace steadymap {
namespace {

// Assumed if getrlimit fails.
constexpr std::size_t kUsualLimit = 1024;

}  // namespace

std::size_t DescriptorLimit() {
  rlimit limit{};
  return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : kUsualLimit;
}

std::size_t CountFreeDescriptors() {
  std::error_code error;
  const std::filesystem::directory_iterator open("/proc/self/fd", error);
  // Opening the folder failed, so no descriptor is free.
  if (error) return 0;
  const auto count = static_cast<std::size_t>(
      std::distance(std::filesystem::begin(open), std::filesystem::end(open)));
  const std::size_t limit = DescriptorLimit();
  return limit > count ? limit - count : 0;
}

std::size_t ReservedDescriptors(std::size_t limit) {
  return std::clamp<std::size_t>(limit / 4, 64, 4096);
}

}  // namespace steadymap

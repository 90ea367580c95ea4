#include "server/process/memory_guard.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <unistd.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::chrono::milliseconds kMeasureInterval{100};

// Long enough to keep refused clients from retrying in a tight loop; short compared with the
// release of the memory of a deleted map or a finished export.
constexpr std::int64_t kRetryDelayMs = 1000;

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

/// Returns MemTotal of /proc/meminfo, which is in KiB.
std::size_t MachineBytes(const std::filesystem::path& root) {
  std::ifstream file(root / "proc/meminfo");
  for (std::string name, unit; file >> name;) {
    std::size_t kib = 0;
    if (name == "MemTotal:" && file >> kib) return kib << 10;
    std::getline(file, unit);
  }
  return kNoLimit;
}

/// Returns the memory limit of one control group. "max" or a missing file means no limit.
std::size_t LimitOf(const std::filesystem::path& group) {
  std::ifstream file(group / "memory.max");
  std::string text;
  std::size_t bytes = 0;
  return file >> text && absl::SimpleAtoi(text, &bytes) ? bytes : kNoLimit;
}

/// Returns the smallest memory limit of the control group of the process and its ancestors, in the
/// unified hierarchy.
std::size_t ControlGroupBytes(const std::filesystem::path& root) {
  std::ifstream file(root / "proc/self/cgroup");
  const std::filesystem::path hierarchy = root / "sys/fs/cgroup";
  std::size_t bytes = LimitOf(hierarchy);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("0::/")) continue;
    std::filesystem::path group = hierarchy;
    for (const std::filesystem::path& part : std::filesystem::path(line.substr(4))) {
      group /= part;
      bytes = std::min(bytes, LimitOf(group));
    }
  }
  return bytes;
}

std::size_t BoundOf(std::size_t max_bytes) {
  return max_bytes == 0 ? UsableMemoryBytes() / 4 * 3 : max_bytes;
}

}  // namespace

std::size_t ResidentBytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t total_pages = 0;
  std::size_t resident_pages = 0;
  file >> total_pages >> resident_pages;
  return resident_pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

std::size_t UsableMemoryBytes(const std::filesystem::path& root) {
  return std::min(MachineBytes(root), ControlGroupBytes(root));
}

MemoryGuard::MemoryGuard(std::size_t max_bytes, std::function<std::size_t()> measure)
    : measure_(std::move(measure)), max_bytes_(BoundOf(max_bytes)) {}

void MemoryGuard::SetMax(std::size_t max_bytes) { max_bytes_ = BoundOf(max_bytes); }

std::size_t MemoryGuard::Measure() const {
  const Clock::time_point now = Clock::now();
  const absl::MutexLock lock(&mutex_);
  if (measured_ == Clock::time_point::min() || now - measured_ >= kMeasureInterval) {
    bytes_ = measure_();
    measured_ = now;
  }
  return bytes_;
}

absl::Status MemoryGuard::Check() const {
  const std::size_t bytes = Measure();
  const std::size_t max_bytes = max_bytes_;
  if (bytes <= max_bytes) return absl::OkStatus();
  return WithRetryDelay(MakeError(absl::StatusCode::kResourceExhausted,
                                  reason::kMemoryLow,
                                  absl::StrCat("the server uses ",
                                               bytes,
                                               " bytes of memory, more than its limits.memory_bytes"
                                               " of ",
                                               max_bytes,
                                               "; it accepts no frames and no new maps until "
                                               "it uses less")),
                        kRetryDelayMs);
}

}  // namespace steadymap

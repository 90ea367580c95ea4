#include "tests/benchmark/process_usage.h"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include <unistd.h>

namespace steadymap::benchmarks {
namespace {

constexpr double kMbPerKibibyte = 1024e-6;

// Fields of /proc/PID/stat between the process's name and its user and system time.
constexpr int kFieldsBeforeTimes = 11;

}  // namespace

ProcessUsage UsageOf(pid_t process) {
  const std::string folder = "/proc/" + std::to_string(process);
  ProcessUsage usage;
  std::ifstream status(folder + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmRSS:", 0) == 0) {
      usage.resident_mb = std::strtod(line.c_str() + 6, nullptr) * kMbPerKibibyte;
    } else if (line.rfind("VmHWM:", 0) == 0) {
      usage.peak_resident_mb = std::strtod(line.c_str() + 6, nullptr) * kMbPerKibibyte;
    }
  }
  std::string stat;
  std::getline(std::ifstream(folder + "/stat"), stat);
  const std::size_t name_end = stat.rfind(')');
  if (name_end == std::string::npos) return usage;
  std::istringstream fields(stat.substr(name_end + 1));
  std::string skipped;
  for (int i = 0; i < kFieldsBeforeTimes; ++i) fields >> skipped;
  double user_ticks = 0.0;
  double system_ticks = 0.0;
  fields >> user_ticks >> system_ticks;
  usage.processor_s = (user_ticks + system_ticks) / static_cast<double>(sysconf(_SC_CLK_TCK));
  return usage;
}

}  // namespace steadymap::benchmarks

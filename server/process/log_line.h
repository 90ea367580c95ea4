#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include "server/process/logging.h"

namespace steadymap {

/// One record of the log.
struct LogLine {
  std::chrono::system_clock::time_point time;
  std::string_view level;
  std::size_t thread = 0;
  std::string_view message;
};

/// Formats the record as one line, newline included. The result is always one line and, as JSON,
/// valid, because messages quote client input: control characters and bytes that are not UTF-8 are
/// escaped.
std::string FormatLogLine(const LogLine& line, LogFormat format);

}  // namespace steadymap

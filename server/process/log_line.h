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

/// The record as one line, newline included. Whatever the message holds, it stays one line and, as
/// JSON, valid: control characters and bytes that are not UTF-8 are escaped. Messages quote what
/// clients sent.
std::string FormatLogLine(const LogLine& line, LogFormat format);

}  // namespace steadymap

#pragma once

#include <absl/status/status.h>

namespace steadymap {

/// Lowest severity that is written.
enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// How a line of the log looks.
enum class LogFormat {
  kText,  ///< `2026-03-01T12:00:00.000Z info  message`, for people.
  kJson,  ///< One JSON object a line with `time`, `level`, `thread`, `message`, for machines.
};

/// What the daemon says on stderr.
struct LoggingOptions {
  /// `debug` tells every stream and commit; `info` what an operator wants to read a year later.
  LogLevel level = LogLevel::kInfo;

  LogFormat format = LogFormat::kText;
};

/// Sends spdlog's default logger to stderr in the given format. Call before threads are started.
void StartLogging(const LoggingOptions& options);

/// Changes the level of the running log. Any thread.
void SetLogLevel(LogLevel level);

}  // namespace steadymap

#pragma once

#include <absl/status/status.h>

namespace steadymap {

/// Lowest severity that is written.
enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// Format of a log line.
enum class LogFormat {
  kText,  ///< `2026-03-01T12:00:00.000Z info  message`, for people.
  kJson,  ///< One JSON object per line with `time`, `level`, `thread`, `message`, for machines.
};

/// Options of the log on stderr.
struct LoggingOptions {
  /// `debug` logs every stream and commit; `info` logs events that an operator may need a year
  /// later.
  LogLevel level = LogLevel::kInfo;

  LogFormat format = LogFormat::kText;
};

/// Sends the default logger of spdlog to stderr in the given format. Must be called before threads
/// are started.
void StartLogging(const LoggingOptions& options);

/// Changes the level of the running log. Thread-safe.
void SetLogLevel(LogLevel level);

}  // namespace steadymap

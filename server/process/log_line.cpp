#include "server/process/log_line.h"

#include <ctime>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

namespace steadymap {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD in UTF-8.

// Formats a time as RFC 3339 in UTC with milliseconds.
std::string FormatTime(std::chrono::system_clock::time_point time) {
  const auto since_epoch =
      std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch());
  const std::time_t seconds = static_cast<std::time_t>(since_epoch.count() / 1000);
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  return absl::StrFormat("%04d-%02d-%02dT%02d:%02d:%02d.%03dZ",
                         utc.tm_year + 1900,
                         utc.tm_mon + 1,
                         utc.tm_mday,
                         utc.tm_hour,
                         utc.tm_min,
                         utc.tm_sec,
                         static_cast<int>(since_epoch.count() % 1000));
}

// Returns the length in bytes of the UTF-8 character at the start of `text`; 0 if it is invalid.
std::size_t CharacterBytes(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text.front());
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U) return 0;
  }
  // Rejects overlong forms, surrogates, and code points above U+10FFFF.
  const auto second = static_cast<unsigned char>(text[1]);
  if ((lead == 0xE0 && second < 0xA0) || (lead == 0xED && second >= 0xA0)) return 0;
  if ((lead == 0xF0 && second < 0x90) || (lead == 0xF4 && second >= 0x90)) return 0;
  return length;
}

void AppendEscaped(std::string_view text, bool quotes, std::string* out) {
  while (!text.empty()) {
    const std::size_t length = CharacterBytes(text);
    const auto byte = static_cast<unsigned char>(text.front());
    if (length == 0) {
      *out += kReplacement;
    } else if (byte < 0x20 || byte == 0x7F) {
      absl::StrAppend(out, "\\u00", absl::Hex(byte, absl::kZeroPad2));
    } else {
      if (quotes && (byte == '"' || byte == '\\')) *out += '\\';
      out->append(text.substr(0, length));
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
}

}  // namespace

std::string FormatLogLine(const LogLine& line, LogFormat format) {
  const absl::string_view level(line.level.data(), line.level.size());
  std::string text;
  if (format == LogFormat::kJson) {
    text = absl::StrCat("{\"time\":\"",
                        FormatTime(line.time),
                        "\",\"level\":\"",
                        level,
                        "\",\"thread\":",
                        line.thread,
                        ",\"message\":\"");
    AppendEscaped(line.message, true, &text);
    text += "\"}\n";
  } else {
    text = absl::StrFormat("%s %-7s ", FormatTime(line.time), level);
    AppendEscaped(line.message, false, &text);
    text += '\n';
  }
  return text;
}

}  // namespace steadymap

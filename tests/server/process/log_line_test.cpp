#include "server/process/log_line.h"

#include <string>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr std::chrono::system_clock::time_point kTime{std::chrono::milliseconds(1'700'000'000'042)};

std::string Text(std::string_view message) {
  return FormatLogLine({kTime, "info", 7, message}, LogFormat::kText);
}

std::string Json(std::string_view message) {
  return FormatLogLine({kTime, "info", 7, message}, LogFormat::kJson);
}

TEST(FormatLogLine, WritesTimeInUtcLevelAndMessage) {
  EXPECT_EQ(Text("listening"), "2023-11-14T22:13:20.042Z info    listening\n");
  EXPECT_EQ(Json("listening"),
            "{\"time\":\"2023-11-14T22:13:20.042Z\",\"level\":\"info\",\"thread\":7,"
            "\"message\":\"listening\"}\n");
}

TEST(FormatLogLine, NobodyForgesASecondLine) {
  EXPECT_EQ(Text("a\nb\r\x1B[31m"),
            "2023-11-14T22:13:20.042Z info    a\\u000ab\\u000d\\u001b[31m\n");
}

TEST(FormatLogLine, QuotesAndBackslashesStayInsideTheJsonString) {
  EXPECT_NE(Json("a\"b\\c").find("\"message\":\"a\\\"b\\\\c\"}\n"), std::string::npos);
}

TEST(FormatLogLine, KeepsUtf8AndReplacesWhatIsNone) {
  EXPECT_NE(Json("h\xC3\xA4ll \xF0\x9F\xA4\x96").find("h\xC3\xA4ll \xF0\x9F\xA4\x96"),
            std::string::npos);
  // A lone continuation byte, a truncated character, an overlong slash, a surrogate, a code point
  // beyond U+10FFFF.
  for (const char* broken : {"\x80", "\xE2\x82", "\xC0\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80"}) {
    const std::string line = Json(broken);
    EXPECT_NE(line.find("\xEF\xBF\xBD"), std::string::npos);
    EXPECT_EQ(line.find('\x80'), std::string::npos);
    EXPECT_EQ(line.find('\xC0'), std::string::npos);
  }
}

}  // namespace
}  // namespace steadymap

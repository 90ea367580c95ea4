#include "client/cli/text/json_text.h"

#include <cstdint>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

/// Returns the text of a value without its line feed.
std::string Spelled(const Json& value) {
  std::string document = JsonLine(value);
  EXPECT_EQ(document.back(), '\n');
  document.pop_back();
  return document;
}

TEST(JsonText, MembersKeepTheirOrder) {
  Json json = {{"zebra", 1}, {"ant", 2}};
  json["mouse"] = 3;
  json.update({{"bee", 4}, {"ape", 5}});
  EXPECT_EQ(JsonLine(json), "{\"zebra\":1,\"ant\":2,\"mouse\":3,\"bee\":4,\"ape\":5}\n");
}

TEST(JsonText, IndentedHasAValueALine) {
  const Json json = {{"name", "kitchen"},
                     {"point", {1.5, 2}},
                     {"nothing", Json::object()},
                     {"empty", Json::array()},
                     {"known", true},
                     {"other", nullptr}};
  EXPECT_EQ(IndentedJson(json),
            "{\n"
            "  \"name\": \"kitchen\",\n"
            "  \"point\": [\n"
            "    1.5,\n"
            "    2\n"
            "  ],\n"
            "  \"nothing\": {},\n"
            "  \"empty\": [],\n"
            "  \"known\": true,\n"
            "  \"other\": null\n"
            "}\n");
}

TEST(JsonText, AStreamHasADocumentALine) {
  const Json json = {{"point", VectorJson(1.5, -2.0, 0.25)}, {"text", "a\nb"}};
  EXPECT_EQ(JsonLine(json), "{\"point\":[1.5,-2.0,0.25],\"text\":\"a\\nb\"}\n");
}

TEST(JsonText, TextIsEscaped) {
  EXPECT_EQ(Spelled("a\"b\\c/d"), R"("a\"b\\c/d")");
  EXPECT_EQ(Spelled("\n\t\r"), R"("\n\t\r")");
  EXPECT_EQ(Spelled(std::string("\0\x1F\x7F", 3)), "\"\\u0000\\u001f\x7F\"");
}

TEST(JsonText, WellFormedUtf8PassesAndTheRestIsReplaced) {
  const std::string well_formed = "\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x98\x80";
  EXPECT_EQ(Spelled(well_formed), '"' + well_formed + '"');
  const std::string replacement = "\xEF\xBF\xBD";
  EXPECT_EQ(Spelled("a\xFFz"), "\"a" + replacement + "z\"");
  for (const char* broken : {"\xE2\x82", "\xC0\xAF", "\xED\xA0\x80", "\xF5\x80\x80\x80"}) {
    const std::string text = Spelled(std::string("a") + broken + 'z');
    EXPECT_TRUE(text.starts_with("\"a" + replacement)) << text;
    EXPECT_TRUE(text.ends_with(replacement + "z\"")) << text;
    EXPECT_EQ(text.find(broken), std::string::npos) << text;
    EXPECT_TRUE(Json::accept(text)) << text;
  }
  Json as_key;
  as_key["\xFF"] = 1;
  EXPECT_EQ(Spelled(as_key), "{\"" + replacement + "\":1}");
}

TEST(JsonText, NumbersReadBackAsTheyWere) {
  EXPECT_EQ(Spelled(0.05), "0.05");
  for (const double value : {-3.0, 1.0 / 3.0, 1e-300, 1'714'564'800.25}) {
    EXPECT_EQ(Json::parse(Spelled(value)).get<double>(), value);
  }
}

TEST(JsonText, WhatJsonCannotHoldIsNull) {
  EXPECT_EQ(Spelled(std::numeric_limits<double>::quiet_NaN()), "null");
  EXPECT_EQ(Spelled(-std::numeric_limits<double>::infinity()), "null");
}

TEST(JsonText, LargeCountsKeepAllDigits) {
  EXPECT_EQ(Spelled(std::numeric_limits<std::uint64_t>::max()), "18446744073709551615");
}

}  // namespace
}  // namespace steadymap

#include "client/cli/text/json_writer.h"

#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

std::string Quoted(std::string_view text) {
  std::string document = JsonWriter().Text(text).Finish();
  document.pop_back();
  return document;
}

std::string Spelled(double value) {
  std::string document = JsonWriter().Number(value).Finish();
  document.pop_back();
  return document;
}

TEST(JsonWriter, NestsObjectsAndArrays) {
  JsonWriter json;
  json.BeginObject();
  json.Key("name").Text("kitchen");
  json.Key("point").BeginArray().Number(1.5).Integer(2).EndArray();
  json.Key("nothing").BeginObject().EndObject();
  json.Key("empty").BeginArray().EndArray();
  json.Key("known").Boolean(true);
  json.Key("other").Null();
  json.EndObject();
  EXPECT_EQ(json.Finish(),
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

TEST(JsonWriter, AStreamHasADocumentALine) {
  JsonWriter json(JsonLayout::kOneLine);
  json.BeginObject();
  json.Key("point").BeginArray().Number(1.5).Integer(2).EndArray();
  json.Key("nothing").BeginObject().EndObject();
  json.Key("text").Text("a\nb");
  json.EndObject();
  EXPECT_EQ(json.Finish(), "{\"point\": [1.5, 2], \"nothing\": {}, \"text\": \"a\\nb\"}\n");
}

TEST(JsonWriter, TextIsEscaped) {
  EXPECT_EQ(Quoted("a\"b\\c/d"), R"("a\"b\\c/d")");
  EXPECT_EQ(Quoted("\n\t\r"), R"("\n\t\r")");
  EXPECT_EQ(Quoted(std::string_view("\0\x1F\x7F", 3)), "\"\\u0000\\u001f\x7F\"");
}

TEST(JsonWriter, WellFormedUtf8PassesAndTheRestIsReplaced) {
  const std::string well_formed = "\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x98\x80";
  EXPECT_EQ(Quoted(well_formed), '"' + well_formed + '"');
  const std::string replacement = "\xEF\xBF\xBD";
  EXPECT_EQ(Quoted("a\xFFz"), "\"a" + replacement + "z\"");
  EXPECT_EQ(Quoted("\xE2\x82"), '"' + replacement + replacement + '"') << "cut short";
  EXPECT_EQ(Quoted("\xC0\xAF"), '"' + replacement + replacement + '"') << "overlong";
  EXPECT_EQ(Quoted("\xED\xA0\x80"), '"' + replacement + replacement + replacement + '"')
      << "surrogate";
}

TEST(JsonWriter, NumbersReadBackAsTheyWere) {
  EXPECT_EQ(Spelled(0.05), "0.05");
  EXPECT_EQ(Spelled(-3.0), "-3");
  EXPECT_EQ(std::stod(Spelled(1.0 / 3.0)), 1.0 / 3.0);
  EXPECT_EQ(std::stod(Spelled(1e-300)), 1e-300);
}

TEST(JsonWriter, WhatJsonCannotHoldIsNull) {
  EXPECT_EQ(Spelled(std::numeric_limits<double>::quiet_NaN()), "null");
  EXPECT_EQ(Spelled(-std::numeric_limits<double>::infinity()), "null");
}

TEST(JsonWriter, LargeCountsKeepAllDigits) {
  EXPECT_EQ(JsonWriter().Integer(std::numeric_limits<std::uint64_t>::max()).Finish(),
            "18446744073709551615\n");
}

}  // namespace
}  // namespace steadymap

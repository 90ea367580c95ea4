#include "client/cli/text/json_writer.h"

#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace steadymap {
namespace {

constexpr std::string_view kReplacementCharacter = "\xEF\xBF\xBD";

// Returns the number of bytes of the UTF-8 character at the front of `text`; 0 if there is none.
// Overlong forms, surrogates and code points beyond U+10FFFF are not characters.
std::size_t CharacterLength(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  const bool is_overlong = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xF0 && byte(1) < 0x90);
  const bool is_out_of_range =
      (first == 0xED && byte(1) > 0x9F) || (first == 0xF4 && byte(1) > 0x8F);
  return is_overlong || is_out_of_range ? 0 : length;
}

void AppendEscaped(char c, std::string* text) {
  switch (c) {
    case '"':
      *text += "\\\"";
      return;
    case '\\':
      *text += "\\\\";
      return;
    case '\n':
      *text += "\\n";
      return;
    case '\t':
      *text += "\\t";
      return;
    case '\r':
      *text += "\\r";
      return;
    default:
      break;
  }
  if (static_cast<unsigned char>(c) >= 0x20) {
    *text += c;
    return;
  }
  std::array<char, 8> escape{};
  std::snprintf(escape.data(), escape.size(), "\\u%04x", static_cast<unsigned>(c));
  *text += escape.data();
}

void AppendQuoted(std::string_view value, std::string* text) {
  *text += '"';
  while (!value.empty()) {
    const std::size_t length = CharacterLength(value);
    if (length == 0) *text += kReplacementCharacter;
    if (length == 1) AppendEscaped(value.front(), text);
    if (length > 1) *text += value.substr(0, length);
    value.remove_prefix(length == 0 ? 1 : length);
  }
  *text += '"';
}

}  // namespace

JsonWriter& JsonWriter::BeginObject() {
  Begin('{');
  return *this;
}

JsonWriter& JsonWriter::EndObject() {
  End('}');
  return *this;
}

JsonWriter& JsonWriter::BeginArray() {
  Begin('[');
  return *this;
}

JsonWriter& JsonWriter::EndArray() {
  End(']');
  return *this;
}

JsonWriter& JsonWriter::Key(std::string_view key) {
  assert(!is_empty_.empty() && !after_key_);
  BeginValue();
  AppendQuoted(key, &text_);
  text_ += ": ";
  after_key_ = true;
  return *this;
}

JsonWriter& JsonWriter::Text(std::string_view value) {
  BeginValue();
  AppendQuoted(value, &text_);
  return *this;
}

JsonWriter& JsonWriter::Number(double value) {
  if (!std::isfinite(value)) return Null();
  BeginValue();
  std::array<char, 32> digits{};
  const std::to_chars_result end =
      std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text_.append(digits.data(), end.ptr);
  return *this;
}

JsonWriter& JsonWriter::Vector(double x, double y, double z) {
  return BeginArray().Number(x).Number(y).Number(z).EndArray();
}

JsonWriter& JsonWriter::Integer(std::uint64_t value) {
  BeginValue();
  text_ += std::to_string(value);
  return *this;
}

JsonWriter& JsonWriter::Boolean(bool value) {
  BeginValue();
  text_ += value ? "true" : "false";
  return *this;
}

JsonWriter& JsonWriter::Null() {
  BeginValue();
  text_ += "null";
  return *this;
}

std::string JsonWriter::Finish() const {
  assert(is_empty_.empty() && !after_key_);
  return text_ + '\n';
}

// Separates the next value from the previous one.
void JsonWriter::BeginValue() {
  if (after_key_) {
    after_key_ = false;
    return;
  }
  if (is_empty_.empty()) return;
  if (!is_empty_.back()) text_ += layout_ == JsonLayout::kOneLine ? ", " : ",";
  is_empty_.back() = false;
  NewLine();
}

void JsonWriter::Begin(char bracket) {
  BeginValue();
  text_ += bracket;
  is_empty_.push_back(true);
}

void JsonWriter::End(char bracket) {
  assert(!is_empty_.empty() && !after_key_);
  const bool was_empty = is_empty_.back();
  is_empty_.pop_back();
  if (!was_empty) NewLine();
  text_ += bracket;
}

void JsonWriter::NewLine() {
  if (layout_ == JsonLayout::kOneLine) return;
  text_ += '\n';
  text_.append(2 * is_empty_.size(), ' ');
}

}  // namespace steadymap

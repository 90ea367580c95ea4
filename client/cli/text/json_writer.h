#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace steadymap {

/// How a JSON document is laid out.
enum class JsonLayout {
  kIndented,  ///< A value a line, two spaces an indentation level.
  kOneLine,   ///< All in one line, for streams of documents.
};

/// Writes one JSON document (RFC 8259). The caller's order is kept. Keys and values must alternate
/// within objects, and every Begin must have its End (asserted).
class JsonWriter {
 public:
  explicit JsonWriter(JsonLayout layout = JsonLayout::kIndented) : layout_(layout) {}

  JsonWriter& BeginObject();
  JsonWriter& EndObject();
  JsonWriter& BeginArray();
  JsonWriter& EndArray();

  /// The name of the value that comes next.
  JsonWriter& Key(std::string_view key);

  /// Text in UTF-8; bytes that are not become U+FFFD.
  JsonWriter& Text(std::string_view value);

  /// The shortest spelling that reads back as `value`; null for NaN and infinity, which JSON lacks.
  JsonWriter& Number(double value);

  /// An array of three numbers.
  JsonWriter& Vector(double x, double y, double z);

  JsonWriter& Integer(std::uint64_t value);
  JsonWriter& Boolean(bool value);
  JsonWriter& Null();

  /// The document, with a line feed at its end. Everything must be closed (asserted).
  std::string Finish() const;

 private:
  void BeginValue();
  void Begin(char bracket);
  void End(char bracket);
  void NewLine();

  JsonLayout layout_;
  std::string text_;
  std::vector<bool> is_empty_;  ///< One an open object or array, innermost last.
  bool after_key_ = false;
};

}  // namespace steadymap

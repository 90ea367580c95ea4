#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace steadymap {

/// The layout of a JSON document.
enum class JsonLayout {
  kIndented,  ///< One value per line, two spaces per level.
  kOneLine,   ///< The whole document in one line, for streams of documents.
};

/// Writes one JSON document (RFC 8259), in the order of the calls. Keys and values must alternate
/// within objects, and every Begin needs its End (asserted).
class JsonWriter {
 public:
  explicit JsonWriter(JsonLayout layout = JsonLayout::kIndented) : layout_(layout) {}

  JsonWriter& BeginObject();
  JsonWriter& EndObject();
  JsonWriter& BeginArray();
  JsonWriter& EndArray();

  /// Writes the key of the next value.
  JsonWriter& Key(std::string_view key);

  /// Writes UTF-8 text. Invalid bytes become U+FFFD.
  JsonWriter& Text(std::string_view value);

  /// Writes the shortest decimal text that parses to `value`; null for NaN and infinity, which JSON
  /// does not have.
  JsonWriter& Number(double value);

  /// Writes an array of three numbers.
  JsonWriter& Vector(double x, double y, double z);

  JsonWriter& Integer(std::uint64_t value);
  JsonWriter& Boolean(bool value);
  JsonWriter& Null();

  /// Returns the document, with a line feed at its end. All objects and arrays must be closed
  /// (asserted).
  std::string Finish() const;

 private:
  void BeginValue();
  void Begin(char bracket);
  void End(char bracket);
  void NewLine();

  JsonLayout layout_;
  std::string text_;
  std::vector<bool> is_empty_;  ///< One element per open object or array, innermost last.
  bool after_key_ = false;
};

}  // namespace steadymap

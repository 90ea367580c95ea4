#pragma once

#include <string>

#include <nlohmann/json.hpp>

/// JSON documents (RFC 8259) and their text. NaN and infinity, which JSON does not have, are
/// written as null; bytes that are not UTF-8 are replaced by U+FFFD.
namespace steadymap {

/// A JSON value. The members of an object keep the order in which they are added.
using Json = nlohmann::ordered_json;

/// Returns a document with one value per line, two spaces per level, and a line feed at its end.
std::string IndentedJson(const Json& document);

/// Returns a document as one line with its line feed, for streams of documents.
std::string JsonLine(const Json& document);

/// Returns an array of three numbers.
Json VectorJson(double x, double y, double z);

}  // namespace steadymap

#include "client/cli/maps/class_table_file.h"

#include <charconv>
#include <cstdint>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

namespace steadymap {
namespace {

constexpr int kMaxClassId = std::numeric_limits<std::uint16_t>::max();

// A file that is not a class table may contain words of any length.
constexpr std::size_t kMaxMessageBytes = 300;

std::optional<ClassMotion> ParseMotion(const std::string& word) {
  if (word == "static") return ClassMotion::kStatic;
  if (word == "semi-static") return ClassMotion::kSemiStatic;
  if (word == "dynamic") return ClassMotion::kDynamic;
  return std::nullopt;
}

absl::StatusOr<ClassId> ParseClassId(const std::string& word) {
  std::uint16_t id = 0;
  const char* const end = word.data() + word.size();
  const std::from_chars_result parsed = std::from_chars(word.data(), end, id);
  if (parsed.ec == std::errc() && parsed.ptr == end) return ClassId(id);
  return absl::InvalidArgumentError(
      absl::StrCat("expected an id in [0, ", kMaxClassId, "], got \"", word, "\""));
}

// Parses the last word of a line, the motion or `background`.
absl::Status ParseTraits(const std::string& word, SemanticClass* semantic_class) {
  if (word == "background") {
    semantic_class->in_background = true;
    return absl::OkStatus();
  }
  const std::optional<ClassMotion> motion = ParseMotion(word);
  if (motion) {
    semantic_class->motion = *motion;
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("expected static, semi-static, dynamic or background as the last word, got \"",
                   word,
                   "\"; a name of several words must be followed by one of these words"));
}

// Parses a class from the words of its line, of which there is at least one. Error messages contain
// neither file nor line.
absl::StatusOr<SemanticClass> ParseClass(std::vector<std::string> words) {
  const absl::StatusOr<ClassId> id = ParseClassId(words.front());
  if (!id.ok()) return id.status();
  if (words.size() < 2) return absl::InvalidArgumentError("expected a name after the id, got none");
  SemanticClass semantic_class;
  semantic_class.id = *id;
  if (words.size() > 2) {
    const absl::Status traits = ParseTraits(words.back(), &semantic_class);
    if (!traits.ok()) return traits;
    words.pop_back();
  }
  semantic_class.name = absl::StrJoin(words.begin() + 1, words.end(), " ");
  return semantic_class;
}

absl::Status AtLine(const std::filesystem::path& file, int number, const absl::Status& status) {
  return absl::Status(
      status.code(),
      absl::StrCat(file.string(), ":", number, ": ", status.message().substr(0, kMaxMessageBytes)));
}

}  // namespace

absl::StatusOr<std::vector<SemanticClass>> LoadClassTable(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) {
    return absl::NotFoundError(absl::StrCat("cannot read the class table ", file.string()));
  }
  std::vector<SemanticClass> classes;
  std::map<ClassId, int> line_of;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::istringstream text(line.substr(0, line.find('#')));
    std::vector<std::string> words;
    for (std::string word; text >> word;) words.push_back(word);
    if (words.empty()) continue;
    absl::StatusOr<SemanticClass> semantic_class = ParseClass(words);
    if (!semantic_class.ok()) return AtLine(file, number, semantic_class.status());
    const auto [first, is_new] = line_of.emplace(semantic_class->id, number);
    if (!is_new) {
      return AtLine(
          file,
          number,
          absl::InvalidArgumentError(absl::StrCat(
              "expected each id once, got ", words[0], " again after line ", first->second)));
    }
    classes.push_back(*std::move(semantic_class));
  }
  if (classes.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.string(), ": expected at least one class, got none"));
  }
  return classes;
}

}  // namespace steadymap

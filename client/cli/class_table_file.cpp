#include "client/cli/class_table_file.h"

#include <charconv>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>

#include <absl/strings/str_cat.h>

namespace steadymap {
namespace {

std::optional<ClassMotion> ParseMotion(const std::string& word) {
  if (word == "static") return ClassMotion::kStatic;
  if (word == "semi-static") return ClassMotion::kSemiStatic;
  if (word == "dynamic") return ClassMotion::kDynamic;
  return std::nullopt;
}

std::optional<ClassId> ParseClassId(const std::string& word) {
  std::uint16_t id = 0;
  const char* const end = word.data() + word.size();
  const std::from_chars_result parsed = std::from_chars(word.data(), end, id);
  if (parsed.ec != std::errc() || parsed.ptr != end) return std::nullopt;
  return ClassId(id);
}

// What the last word of a line may say of a class.
bool ParseTraits(const std::string& word, SemanticClass* semantic_class) {
  if (word == "background") {
    semantic_class->in_background = true;
    return true;
  }
  const std::optional<ClassMotion> motion = ParseMotion(word);
  if (motion) semantic_class->motion = *motion;
  return motion.has_value();
}

// A class from the words of its line; none if they are not one.
std::optional<SemanticClass> ParseClass(std::vector<std::string> words) {
  const std::optional<ClassId> id = ParseClassId(words.front());
  if (!id || words.size() < 2) return std::nullopt;
  SemanticClass semantic_class;
  semantic_class.id = *id;
  if (words.size() > 2 && ParseTraits(words.back(), &semantic_class)) words.pop_back();
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (i > 1) semantic_class.name += ' ';
    semantic_class.name += words[i];
  }
  return semantic_class;
}

}  // namespace

absl::StatusOr<std::vector<SemanticClass>> LoadClassTable(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) {
    return absl::NotFoundError(absl::StrCat("cannot read the class table ", file.string()));
  }
  std::vector<SemanticClass> classes;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::istringstream text(line.substr(0, line.find('#')));
    std::vector<std::string> words;
    for (std::string word; text >> word;) words.push_back(word);
    if (words.empty()) continue;
    const std::optional<SemanticClass> semantic_class = ParseClass(words);
    if (!semantic_class) {
      return absl::InvalidArgumentError(
          absl::StrCat(file.string(),
                       ":",
                       number,
                       ": expected ID NAME [static|semi-static|dynamic|background] with an id in "
                       "[0, 65535], got \"",
                       line.substr(0, 80),
                       "\""));
    }
    classes.push_back(*semantic_class);
  }
  if (classes.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(file.string(), ": holds no class"));
  }
  return classes;
}

}  // namespace steadymap

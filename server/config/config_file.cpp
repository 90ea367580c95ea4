#include "server/config/config_file.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <system_error>
#include <vector>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>
#include <toml++/toml.h>

#include "core/types/absl_text.h"
#include "server/config/config_fields.h"

namespace steadymap {
namespace {

constexpr std::size_t kLineWidth = 100;

std::string JoinChoices(std::span<const std::string_view> choices) {
  return absl::StrJoin(choices, ", ", [](std::string* out, std::string_view choice) {
    absl::StrAppend(out, "\"", Absl(choice), "\"");
  });
}

/// Reads the fields from a parsed file and collects all errors in it.
class Loader final : public FieldVisitor {
 public:
  Loader(const toml::table& root, std::string source)
      : root_(root), table_(&root), source_(std::move(source)) {}

  void Section(std::string_view name, std::string_view /*documentation*/) override {
    FindUnknownKeys();
    known_.clear();
    section_ = name;
    sections_.insert(section_);
    table_ = nullptr;
    const toml::node* node = root_.get(name);
    if (node == nullptr) return;
    table_ = node->as_table();
    if (table_ == nullptr) Report(*node, absl::StrCat(section_, " must be a table"));
  }

  void Text(const FieldName& field, std::string* value) override {
    const toml::node* node = Take(field);
    if (node == nullptr) return;
    if (const std::optional<std::string> text = node->value_exact<std::string>()) {
      *value = *text;
    } else {
      ReportType(*node, field, "a string");
    }
  }

  void Flag(const FieldName& field, bool* value) override {
    const toml::node* node = Take(field);
    if (node == nullptr) return;
    if (const std::optional<bool> flag = node->value_exact<bool>()) {
      *value = *flag;
    } else {
      ReportType(*node, field, "true or false");
    }
  }

  void Integer(const FieldName& field,
               const IntegerRange& /*range*/,
               std::int64_t* value) override {
    const toml::node* node = Take(field);
    if (node == nullptr) return;
    if (const std::optional<std::int64_t> number = node->value_exact<std::int64_t>()) {
      *value = *number;
    } else {
      ReportType(*node, field, "an integer");
    }
  }

  void Choice(const FieldName& field,
              std::span<const std::string_view> choices,
              std::size_t* value) override {
    const toml::node* node = Take(field);
    if (node == nullptr) return;
    const std::optional<std::string> text = node->value_exact<std::string>();
    const auto choice = text ? std::find(choices.begin(), choices.end(), *text) : choices.end();
    if (choice != choices.end()) {
      *value = static_cast<std::size_t>(choice - choices.begin());
    } else {
      ReportType(*node, field, "one of " + JoinChoices(choices));
    }
  }

  /// Ends the visit and returns all errors.
  std::vector<std::string> Finish() {
    FindUnknownKeys();
    for (const auto& [key, node] : root_) {
      if (!root_keys_.contains(std::string(key.str())) &&
          !sections_.contains(std::string(key.str()))) {
        ReportAt(key.source().begin, absl::StrCat("unknown key ", Absl(key.str())));
      }
    }
    return problems_;
  }

 private:
  const toml::node* Take(const FieldName& field) {
    known_.emplace(field.name);
    return table_ == nullptr ? nullptr : table_->get(field.name);
  }

  // Unknown keys of the root are found at the end, when all sections are known.
  void FindUnknownKeys() {
    if (section_.empty()) {
      root_keys_ = known_;
      return;
    }
    if (table_ == nullptr) return;
    for (const auto& [key, node] : *table_) {
      if (known_.contains(std::string(key.str()))) continue;
      ReportAt(key.source().begin, absl::StrCat("unknown key ", section_, ".", Absl(key.str())));
    }
  }

  void ReportType(const toml::node& node, const FieldName& field, const std::string& expected) {
    const std::string prefix = section_.empty() ? "" : section_ + ".";
    Report(node, absl::StrCat(prefix, Absl(field.name), " must be ", expected));
  }

  void Report(const toml::node& node, const std::string& problem) {
    ReportAt(node.source().begin, problem);
  }

  void ReportAt(const toml::source_position& position, const std::string& problem) {
    problems_.push_back(
        absl::StrCat(source_, ":", position.line, ":", position.column, ": ", problem));
  }

  const toml::table& root_;
  const toml::table* table_;  ///< Current section; null if the file does not contain it.
  std::string source_;
  std::string section_;
  std::set<std::string> known_;  ///< Keys of the current section.
  std::set<std::string> root_keys_;
  std::set<std::string> sections_;
  std::vector<std::string> problems_;
};

/// Writes the fields as TOML.
class Printer final : public FieldVisitor {
 public:
  void Section(std::string_view name, std::string_view documentation) override {
    text_ += '\n';
    AppendComment(documentation);
    absl::StrAppend(&text_, "[", Absl(name), "]\n");
  }

  void Text(const FieldName& field, std::string* value) override {
    Append(field, {}, Quote(*value));
  }

  void Flag(const FieldName& field, bool* value) override {
    Append(field, {}, *value ? "true" : "false");
  }

  void Integer(const FieldName& field, const IntegerRange& range, std::int64_t* value) override {
    Append(field, absl::StrCat(" In [", range.min, ", ", range.max, "]."), absl::StrCat(*value));
  }

  void Choice(const FieldName& field,
              std::span<const std::string_view> choices,
              std::size_t* value) override {
    Append(field, " One of " + JoinChoices(choices) + ".", Quote(choices[*value]));
  }

  std::string text() && { return std::move(text_); }

 private:
  void Append(const FieldName& field, const std::string& range, const std::string& value) {
    text_ += '\n';
    AppendComment(std::string(field.documentation) + range);
    absl::StrAppend(&text_, Absl(field.name), " = ", value, "\n");
  }

  void AppendComment(std::string_view comment) {
    std::size_t column = 0;
    for (const absl::string_view word : absl::StrSplit(Absl(comment), ' ')) {
      if (column == 0 || column + 1 + word.size() > kLineWidth) {
        absl::StrAppend(&text_, column == 0 ? "" : "\n", "#");
        column = 1;
      }
      absl::StrAppend(&text_, " ", word);
      column += 1 + word.size();
    }
    text_ += '\n';
  }

  // Returns a TOML basic string; characters that TOML does not allow become escapes.
  static std::string Quote(std::string_view value) {
    std::string quoted = "\"";
    for (const char c : value) {
      const auto byte = static_cast<unsigned char>(c);
      if (c == '"' || c == '\\') {
        quoted += {'\\', c};
      } else if (byte < 0x20 || byte == 0x7F) {
        absl::StrAppend(&quoted, "\\u00", absl::Hex(byte, absl::kZeroPad2));
      } else {
        quoted += c;
      }
    }
    return quoted + '"';
  }

  std::string text_ =
      "# Configuration of steadymapd: every setting with its default. `steadymapd --print-config`\n"
      "# prints the effective configuration.\n";
};

absl::StatusOr<toml::table> ParseToml(std::string_view text, const std::string& source) {
  try {
    return toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    const toml::source_position& position = error.source().begin;
    return absl::InvalidArgumentError(absl::StrCat(
        source, ":", position.line, ":", position.column, ": ", Absl(error.description())));
  }
}

}  // namespace

absl::StatusOr<ServerConfig> ParseConfig(std::string_view text, const std::string& source) {
  const absl::StatusOr<toml::table> root = ParseToml(text, source);
  if (!root.ok()) return root.status();
  ServerConfig config;
  Loader loader(*root, source);
  VisitFields(&config, &loader);
  const std::vector<std::string> problems = loader.Finish();
  if (!problems.empty()) return absl::InvalidArgumentError(absl::StrJoin(problems, "\n"));
  return config;
}

absl::StatusOr<ServerConfig> LoadConfigFile(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) && !error) {
    error = std::make_error_code(std::errc::is_a_directory);
  }
  std::ifstream stream;
  if (!error) {
    errno = 0;
    stream.open(file, std::ios::binary);
    if (!stream.is_open()) error = {errno, std::generic_category()};
  }
  if (error) {
    const bool forbidden = error == std::errc::permission_denied;
    return absl::Status(
        forbidden ? absl::StatusCode::kPermissionDenied : absl::StatusCode::kNotFound,
        absl::StrCat("cannot read ", file.string(), ": ", error.message()));
  }
  const std::string text((std::istreambuf_iterator<char>(stream)),
                         std::istreambuf_iterator<char>());
  return ParseConfig(text, file.string());
}

std::string PrintConfig(const ServerConfig& config) {
  ServerConfig copy = config;
  Printer printer;
  VisitFields(&copy, &printer);
  return std::move(printer).text();
}

}  // namespace steadymap

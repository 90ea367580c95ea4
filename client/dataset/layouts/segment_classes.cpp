#include "client/dataset/layouts/segment_classes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include "client/dataset/files/text_file.h"

namespace steadymap {
namespace {

constexpr std::size_t kMaxTableBytes = std::size_t{1} << 20;
constexpr double kMaxId = std::numeric_limits<std::uint16_t>::max();

bool IsId(double number) { return number >= 0 && number <= kMaxId && number == std::floor(number); }

std::vector<std::string> SplitCells(const std::string& line) {
  std::vector<std::string> cells = absl::StrSplit(line, ',');
  for (std::string& cell : cells) absl::StripAsciiWhitespace(&cell);
  return cells;
}

// Returns a cell as a number; NaN, which is not an id, for any other content.
double NumberIn(const std::vector<std::string>& cells, std::size_t column) {
  double number = 0.0;
  const bool is_number = column < cells.size() && absl::SimpleAtod(cells[column], &number);
  return is_number ? number : std::numeric_limits<double>::quiet_NaN();
}

// Returns a number field of an object; NaN if the field is missing or has another type.
double NumberIn(const google::protobuf::Value& object, const char* name) {
  const auto& fields = object.struct_value().fields();
  const auto field = fields.find(name);
  const bool is_number = field != fields.end() && field->second.has_number_value();
  return is_number ? field->second.number_value() : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

bool SegmentClasses::Add(double segment, double class_id) {
  if (!IsId(segment) || !IsId(class_id)) return false;
  const auto to = static_cast<std::uint16_t>(class_id);
  return class_of_.emplace(static_cast<std::uint16_t>(segment), to).first->second == to;
}

absl::StatusOr<SegmentClasses> SegmentClasses::LoadCsv(const std::filesystem::path& file) {
  if (const auto size = SizeOfFile(file, kMaxTableBytes); !size.ok()) return size.status();
  const absl::StatusOr<std::vector<TextLine>> lines = ReadTextLines(file);
  if (!lines.ok()) return lines.status();
  constexpr std::string_view kHeader = "a header with InstanceID and ClassID";
  if (lines->empty()) return MalformedFile(file, kHeader, "no line");
  const std::vector<std::string> header = SplitCells(lines->front().text);
  const auto column_of = [&header](const char* name) {
    return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
  };
  const std::size_t segment_column = column_of("InstanceID");
  const std::size_t class_column = column_of("ClassID");
  if (std::max(segment_column, class_column) == header.size()) {
    return MalformedLine(file, lines->front(), kHeader);
  }
  SegmentClasses classes;
  for (std::size_t i = 1; i < lines->size(); ++i) {
    const std::vector<std::string> cells = SplitCells((*lines)[i].text);
    if (!classes.Add(NumberIn(cells, segment_column), NumberIn(cells, class_column))) {
      return MalformedLine(file, (*lines)[i], "a segment and its only class, both in [0, 65535]");
    }
  }
  return classes;
}

absl::StatusOr<SegmentClasses> SegmentClasses::LoadJson(const std::filesystem::path& file) {
  const absl::StatusOr<std::string> text = ReadFile(file, kMaxTableBytes);
  if (!text.ok()) return text.status();
  google::protobuf::ListValue list;
  const auto parsed = google::protobuf::util::JsonStringToMessage(*text, &list);
  if (!parsed.ok()) return MalformedFile(file, "a JSON list of segments", "other content");
  SegmentClasses classes;
  for (int i = 0; i < list.values_size(); ++i) {
    const google::protobuf::Value& segment = list.values(i);
    if (!classes.Add(NumberIn(segment, "id"), NumberIn(segment, "category_id"))) {
      return MalformedFile(file,
                           "segments with an id and its only category_id, both in [0, 65535]",
                           absl::StrCat("other content in entry ", i + 1));
    }
  }
  return classes;
}

absl::StatusOr<SegmentClasses> SegmentClasses::Load(const std::filesystem::path& file) {
  return file.extension() == ".json" ? LoadJson(file) : LoadCsv(file);
}

std::uint16_t SegmentClasses::ClassOf(std::uint16_t segment) const {
  const auto found = class_of_.find(segment);
  return found != class_of_.end() ? found->second : std::uint16_t{0};
}

void SegmentClasses::Apply(Image<std::uint16_t>* segments) const {
  std::vector<std::uint16_t> classes(std::size_t{1} << 16U);
  for (const auto& [segment, class_id] : class_of_) classes[segment] = class_id;
  std::transform(segments->data(),
                 segments->data() + segments->size(),
                 segments->data(),
                 [&classes](std::uint16_t segment) { return classes[segment]; });
}

}  // namespace steadymap

#include "client/dataset/layouts/label_map.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include "client/dataset/files/text_file.h"

namespace steadymap {
namespace {

constexpr double kMaxLabel = 65535;

bool IsLabel(double number) {
  return number >= 0 && number <= kMaxLabel && number == std::floor(number);
}

}  // namespace

absl::StatusOr<LabelMap> LabelMap::Load(const std::filesystem::path& file) {
  const absl::StatusOr<std::vector<TextLine>> lines = ReadTextLines(file);
  if (!lines.ok()) return lines.status();
  LabelMap map;
  std::vector<bool> is_named;
  for (const TextLine& line : *lines) {
    const std::optional<std::vector<double>> numbers = ParseNumbers(line.text);
    if (!numbers || numbers->size() != 2 || !IsLabel((*numbers)[0]) || !IsLabel((*numbers)[1])) {
      return MalformedLine(file, line, "\"from to\", two class ids in [0, 65535]");
    }
    const auto from = static_cast<std::size_t>((*numbers)[0]);
    if (from >= map.to_.size()) {
      const std::size_t known = map.to_.size();
      map.to_.resize(from + 1);
      is_named.resize(from + 1);
      for (std::size_t id = known; id <= from; ++id) map.to_[id] = static_cast<std::uint16_t>(id);
    }
    if (is_named[from]) return MalformedLine(file, line, "each class at most once");
    is_named[from] = true;
    map.to_[from] = static_cast<std::uint16_t>((*numbers)[1]);
  }
  // With an identity map, images are copied without decoding.
  bool is_identity = true;
  for (std::size_t id = 0; id < map.to_.size(); ++id) is_identity &= map.to_[id] == id;
  if (is_identity) map.to_.clear();
  return map;
}

void LabelMap::Apply(Image<std::uint16_t>* labels) const {
  for (std::size_t i = 0; i < labels->size(); ++i) labels->data()[i] = Apply(labels->data()[i]);
}

}  // namespace steadymap

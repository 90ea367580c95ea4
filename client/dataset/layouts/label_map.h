#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

namespace steadymap {

/// Turns the class ids of a recording into those of a map.
///
/// Its file holds a line `from to` for each class, two integers in [0, 65535]; what follows a # is
/// a comment. Classes that no line names keep their id.
class LabelMap {
 public:
  /// Changes nothing.
  LabelMap() = default;

  /// Reads a label map file.
  /// Errors: `NotFound`; `InvalidArgument` naming the file and line of anything else than a pair of
  /// class ids, or of a class that is mapped twice.
  static absl::StatusOr<LabelMap> Load(const std::filesystem::path& file);

  /// Whether every class keeps its id.
  bool is_identity() const { return to_.empty(); }

  /// The map's class for the recording's.
  std::uint16_t Apply(std::uint16_t from) const { return from < to_.size() ? to_[from] : from; }

  /// Maps every pixel in place.
  void Apply(Image<std::uint16_t>* labels) const;

 private:
  std::vector<std::uint16_t> to_;  ///< By `from`; empty for the identity.
};

}  // namespace steadymap

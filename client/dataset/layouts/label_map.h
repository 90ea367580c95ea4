#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

namespace steadymap {

/// Converts the class ids of a recording to those of a map.
///
/// The file contains a line `from to` for each class, two integers in [0, 65535]. Text after a # is
/// a comment. Classes without a line keep their id.
class LabelMap {
 public:
  /// The identity.
  LabelMap() = default;

  /// Reads a label map file. Errors: `NotFound`; `InvalidArgument` with the file and line in the
  /// message for a line that is not a pair of class ids, and for a class that is mapped twice.
  static absl::StatusOr<LabelMap> Load(const std::filesystem::path& file);

  /// True if every class keeps its id.
  bool is_identity() const { return to_.empty(); }

  /// Returns the map's class for a class of the recording.
  std::uint16_t Apply(std::uint16_t from) const { return from < to_.size() ? to_[from] : from; }

  /// Maps every pixel in place.
  void Apply(Image<std::uint16_t>* labels) const;

 private:
  std::vector<std::uint16_t> to_;  ///< Indexed by `from`; empty for the identity.
};

}  // namespace steadymap

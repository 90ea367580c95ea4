#pragma once

#include <cstdint>
#include <filesystem>
#include <map>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

namespace steadymap {

/// The classes of the segments of an image.
class SegmentClasses {
 public:
  /// Reads a table of at most 1 MiB. Ids and classes are integers in [0, 65535]:
  /// - `.csv`: a header with the columns `InstanceID` and `ClassID`, then one line per segment;
  /// - `.json`: a list of objects, each with `id` and `category_id`.
  /// Errors: `NotFound`; `InvalidArgument` with the file, and the line or entry, in the message for
  /// any other content and for a segment with two classes.
  static absl::StatusOr<SegmentClasses> Load(const std::filesystem::path& file);

  /// Returns the class of a segment; 0 for a segment that is not in the table.
  std::uint16_t ClassOf(std::uint16_t segment) const;

  /// Replaces the segment in every pixel by its class.
  void Apply(Image<std::uint16_t>* segments) const;

 private:
  static absl::StatusOr<SegmentClasses> LoadCsv(const std::filesystem::path& file);
  static absl::StatusOr<SegmentClasses> LoadJson(const std::filesystem::path& file);

  /// Adds a segment. Returns false if a number is not an id or the segment already has another
  /// class.
  bool Add(double segment, double class_id);

  std::map<std::uint16_t, std::uint16_t> class_of_;
};

}  // namespace steadymap

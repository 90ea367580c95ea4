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
  /// Reads a table of at most 1 MiB, ids and classes being integers in [0, 65535]:
  /// - `.csv`: a header that names the columns `InstanceID` and `ClassID`, then a line a segment;
  /// - `.json`: a list of objects, each with `id` and `category_id`.
  /// Errors: `NotFound`; `InvalidArgument` naming the file, and the line or entry, of anything else
  /// and of a segment that has two classes.
  static absl::StatusOr<SegmentClasses> Load(const std::filesystem::path& file);

  /// The class of a segment; 0 for one that the table lacks.
  std::uint16_t ClassOf(std::uint16_t segment) const;

  /// Turns every pixel from a segment into its class.
  void Apply(Image<std::uint16_t>* segments) const;

 private:
  static absl::StatusOr<SegmentClasses> LoadCsv(const std::filesystem::path& file);
  static absl::StatusOr<SegmentClasses> LoadJson(const std::filesystem::path& file);

  /// Whether both are ids, and the segment had no other class.
  bool Add(double segment, double class_id);

  std::map<std::uint16_t, std::uint16_t> class_of_;
};

}  // namespace steadymap

#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "core/types/map_config.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// Checks the frames of an upload for input that is valid but probably unintended. One thread.
class UploadWarnings {
 public:
  /// `policy` is the policy of the map.
  explicit UploadWarnings(UpdatePolicy policy);

  /// Returns a warning for the user, or none. Warns once, at the first frame with neither labels
  /// nor instances in an upload to a map of objects.
  std::optional<std::string> Look(const v1::Frame& frame);

 private:
  bool needs_labels_;
  std::size_t frames_ = 0;
};

}  // namespace steadymap

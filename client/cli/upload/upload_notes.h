#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "core/types/map_config.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// Watches what an upload sends, for what is allowed but hardly meant. One thread.
class UploadNotes {
 public:
  /// `policy` is that of the map.
  explicit UploadNotes(UpdatePolicy policy);

  /// A line for the user, or none. Says of the first frame with neither labels nor instances that a
  /// map of objects sees none in it, and nothing of those behind.
  std::optional<std::string> Look(const v1::Frame& frame);

 private:
  bool wants_labels_;
  std::size_t frames_ = 0;
};

}  // namespace steadymap

#include "client/cli/upload/upload_warnings.h"

#include "core/policy/map_updater.h"

namespace steadymap {

UploadWarnings::UploadWarnings(UpdatePolicy policy) : needs_labels_(NeedsLabels(policy)) {}

std::optional<std::string> UploadWarnings::Look(const v1::Frame& frame) {
  ++frames_;
  if (!needs_labels_ || frame.has_labels() || frame.has_instances()) return std::nullopt;
  needs_labels_ = false;
  return "warning: frame " + std::to_string(frames_) +
         " has neither labels nor instances; this map keeps objects and finds none in such frames "
         "(maps with --policy static or pocd need no labels)";
}

}  // namespace steadymap

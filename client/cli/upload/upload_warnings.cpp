#include "client/cli/upload/upload_warnings.h"

#include "core/policy/map_updater.h"

namespace steadymap {

UploadWarnings::UploadWarnings(UpdatePolicy policy) : needs_labels_(KeepsObjects(policy)) {}

std::optional<std::string> UploadWarnings::Look(const v1::Frame& frame) {
  ++frames_;
  if (!needs_labels_ || frame.has_labels() || frame.has_instances()) return std::nullopt;
  needs_labels_ = false;
  return "warning: frame " + std::to_string(frames_) +
         " has neither labels nor instances; this map keeps objects and finds none in such frames "
         "(a map created with --policy static needs no labels)";
}

}  // namespace steadymap

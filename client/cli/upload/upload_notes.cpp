#include "client/cli/upload/upload_notes.h"

#include "core/policy/map_updater.h"

namespace steadymap {

UploadNotes::UploadNotes(UpdatePolicy policy) : wants_labels_(KeepsObjects(policy)) {}

std::optional<std::string> UploadNotes::Look(const v1::Frame& frame) {
  ++frames_;
  if (!wants_labels_ || frame.has_labels() || frame.has_instances()) return std::nullopt;
  wants_labels_ = false;
  return "warning: frame " + std::to_string(frames_) +
         " has neither labels nor instances; this map keeps objects and finds none in such frames "
         "(a map created with --policy static needs no labels)";
}

}  // namespace steadymap

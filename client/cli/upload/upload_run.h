#pragma once

#include <string>

#include <absl/status/status.h>

#include "client/cli/maps/map_options.h"
#include "client/cli/text/command_context.h"
#include "client/upload/frame_source.h"
#include "core/types/identifiers.h"

namespace CLI {
class App;
}

namespace steadymap {

/// What `upload` and `simulate` have in common.
struct UploadRunOptions {
  std::string map;            ///< As on the command line.
  SensorName source;          ///< What took the frames.
  std::string session;        ///< Id of the upload session; empty: a new one.
  MapOptions new_map;         ///< How a map that does not exist is created; not without a policy.
  bool as_json = false;       ///< The summary is JSON.
  double retry_for_s = 60.0;  ///< How long to try again without any success.
};

/// Adds the options that change an UploadRunOptions, but for the map's name.
void AddUploadRunOptions(CLI::App* command, UploadRunOptions* options);

/// Uploads all frames of `source`, shows the progress, waits until everything is integrated and
/// prints a summary. A map that does not exist is created if the options name its policy.
/// Errors: `InvalidArgument` for bad ids and for options that no map can have; `NotFound` for a map
/// that does not exist and is not to be created; `FailedPrecondition` for one that exists and
/// contradicts the options; what ended the upload; and, once everything else is done,
/// frames that were refused or could not be read.
absl::Status RunUpload(const UploadRunOptions& options,
                       FrameSource* source,
                       CommandContext* context);

}  // namespace steadymap

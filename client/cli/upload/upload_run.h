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

/// The common options of `upload` and `simulate`.
struct UploadRunOptions {
  std::string map;      ///< Map name as given on the command line.
  SensorName source;    ///< Source of the frames.
  std::string session;  ///< Id of the upload session; empty: a new one.
  MapOptions new_map;   ///< Configuration of a new map; a map is created only if a policy is given.
  bool as_json = false;       ///< True: the summary is JSON.
  double retry_for_s = 60.0;  ///< Time after which retries without success end.
};

/// Adds the options that set `options`, except the map's name.
void AddUploadRunOptions(CLI::App* command, UploadRunOptions* options);

/// Uploads all frames of `source`, shows the progress, waits until all frames are integrated and
/// prints a summary. A map that does not exist is created if the options contain its policy.
/// Errors: `InvalidArgument` for invalid ids and for an invalid configuration; `NotFound` for a map
/// that does not exist and is not created; `FailedPrecondition` for an existing map that
/// contradicts the options; the error that ended the upload; and, after all other frames are done,
/// an error for frames that were refused or could not be read.
absl::Status RunUpload(const UploadRunOptions& options,
                       FrameSource* source,
                       CommandContext* context);

}  // namespace steadymap

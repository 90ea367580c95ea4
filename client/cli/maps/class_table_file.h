#pragma once

#include <filesystem>
#include <vector>

#include <absl/status/statusor.h>

#include "core/types/map_config.h"

namespace steadymap {

/// Reads a class table: one line `ID NAME [static|semi-static|dynamic|background]` for each class,
/// with unique ids in [0, 65535]. The default motion is static. `background` is a static class
/// whose surfaces form no objects. A name of several words must be followed by its motion, so that
/// a misspelt motion is not parsed as part of the name. Text after a # is a comment. Errors:
/// `NotFound` for a missing file; `InvalidArgument` with the file and line in the message for any
/// other content, and for a file without a class.
absl::StatusOr<std::vector<SemanticClass>> LoadClassTable(const std::filesystem::path& file);

}  // namespace steadymap

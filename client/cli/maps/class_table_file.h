#pragma once

#include <filesystem>
#include <vector>

#include <absl/status/statusor.h>

#include "core/types/map_config.h"

namespace steadymap {

/// Reads a class table: a line `ID NAME [static|semi-static|dynamic|background]` a class, each id
/// in [0, 65535] and there once. The motion is static where none is given; `background` is a static
/// class whose surfaces form no objects. A name of several words needs its motion behind it, so
/// that a misspelt motion is not taken for a part of the name. What follows a # is a comment.
/// Errors: `NotFound` for a missing file; `InvalidArgument` naming the file and line of anything
/// else, and for a file without any class.
absl::StatusOr<std::vector<SemanticClass>> LoadClassTable(const std::filesystem::path& file);

}  // namespace steadymap

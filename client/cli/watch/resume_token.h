#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

/// Resume tokens as text, and files that keep one.
namespace steadymap {

/// A token as people and scripts carry it: URL-safe base64 without padding.
std::string ResumeTokenText(std::string_view token);

/// Errors: `InvalidArgument` for what is no such text, or empty.
absl::StatusOr<std::string> ParseResumeToken(std::string_view text);

/// The token that a file keeps; empty if there is no such file. Errors: `InvalidArgument` with the
/// path for a file that cannot be read or holds anything else.
absl::StatusOr<std::string> ReadTokenFile(const std::filesystem::path& path);

/// Makes the file keep `token`, whole or not at all. Errors: as the disk gives them, with the path.
absl::Status WriteTokenFile(const std::filesystem::path& path, std::string_view token);

}  // namespace steadymap

#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

/// Resume tokens as text and in files.
namespace steadymap {

/// Returns a token as text: URL-safe base64 without padding.
std::string ResumeTokenText(std::string_view token);

/// Parses the text of a token. Errors: `InvalidArgument` for empty or any other text.
absl::StatusOr<std::string> ParseResumeToken(std::string_view text);

/// Returns the token stored in a file; empty if the file does not exist. Errors: `InvalidArgument`
/// with the path in the message for a file that cannot be read or has other content.
absl::StatusOr<std::string> ReadTokenFile(const std::filesystem::path& path);

/// Writes `token` to the file atomically. Errors: the error of the file system, with the path.
absl::Status WriteTokenFile(const std::filesystem::path& path, std::string_view token);

}  // namespace steadymap

#include "client/cli/watch/resume_token.h"

#include <fstream>
#include <system_error>

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include "client/cli/text/output_file.h"

namespace steadymap {
namespace {

// Far more than the length of any token.
constexpr std::streamsize kMaxTokenFileBytes = 4096;

}  // namespace

std::string ResumeTokenText(std::string_view token) {
  return absl::WebSafeBase64Escape(absl::string_view(token.data(), token.size()));
}

absl::StatusOr<std::string> ParseResumeToken(std::string_view text) {
  std::string token;
  if (!text.empty() &&
      absl::WebSafeBase64Unescape(absl::string_view(text.data(), text.size()), &token) &&
      !token.empty()) {
    return token;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("expected a resume token, got \"", std::string(text.substr(0, 80)), "\""));
}

absl::StatusOr<std::string> ReadTokenFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) return std::string();
  std::string text(kMaxTokenFileBytes, '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(text.data(), kMaxTokenFileBytes);
  if (error || stream.bad() || !stream.eof()) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ": cannot read a resume token"));
  }
  text.resize(static_cast<std::size_t>(stream.gcount()));
  const absl::string_view stripped = absl::StripAsciiWhitespace(text);
  absl::StatusOr<std::string> token = ParseResumeToken({stripped.data(), stripped.size()});
  if (token.ok()) return token;
  return absl::InvalidArgumentError(absl::StrCat(path.string(), ": ", token.status().message()));
}

absl::Status WriteTokenFile(const std::filesystem::path& path, std::string_view token) {
  absl::StatusOr<OutputFile> file = OutputFile::Create(path);
  if (!file.ok()) return file.status();
  absl::Status status = file->Write(ResumeTokenText(token) + "\n");
  return status.ok() ? file->Commit() : status;
}

}  // namespace steadymap

#include "client/cli/text/error_line.h"

#include <string_view>

#include "core/types/error.h"

namespace steadymap {
namespace {

// The rest of gRPC's message contains the same information.
constexpr std::string_view kGrpcPreamble = "failed to connect to all addresses; last error: ";

}  // namespace

std::string ErrorLine(const absl::Status& status, const std::string& server) {
  std::string line(status.message());
  if (line.empty()) line = absl::StatusCodeToString(status.code());
  const std::string reason = ReasonOf(status);
  if (status.code() == absl::StatusCode::kUnavailable && reason.empty()) {
    if (line.starts_with(kGrpcPreamble)) line.erase(0, kGrpcPreamble.size());
    line = "cannot reach a server at " + server + " (" + line + ")";
  }
  const std::string field = FieldOf(status);
  if (!reason.empty()) line += " [" + reason + (field.empty() ? "" : ", " + field) + "]";
  return line;
}

}  // namespace steadymap

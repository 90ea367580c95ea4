#include "server/config/listen_address.h"

#include <charconv>
#include <string_view>
#include <system_error>

namespace steadymap {
namespace {

constexpr std::string_view kUnixPrefix = "unix:";
constexpr int kMaxPort = 65535;

}  // namespace

std::optional<ListenAddress> ParseListenAddress(const std::string& listen) {
  const std::string_view text = listen;
  if (text.starts_with(kUnixPrefix)) {
    const std::string_view path = text.substr(kUnixPrefix.size());
    if (path.empty()) return std::nullopt;
    return ListenAddress{{}, 0, std::string(path)};
  }
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  int number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (error != std::errc() || end != port.data() + port.size()) return std::nullopt;
  if (number < 0 || number > kMaxPort) return std::nullopt;
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
    if (host.empty()) return std::nullopt;
  } else if (host.find(':') != std::string_view::npos) {
    // Several colons mean an IPv6 address without brackets, in which the port is ambiguous.
    return std::nullopt;
  }
  return ListenAddress{std::string(host), number, {}};
}

}  // namespace steadymap

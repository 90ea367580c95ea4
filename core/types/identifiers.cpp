#include "core/types/identifiers.h"

#include <algorithm>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::size_t kMaxIdLength = 63;
constexpr std::string_view kTenantsPrefix = "tenants/";
constexpr std::string_view kMapsInfix = "/maps/";

bool IsIdTail(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; }

}  // namespace

bool IsValidId(std::string_view text) {
  if (text.empty() || text.size() > kMaxIdLength) return false;
  if (text.front() < 'a' || text.front() > 'z') return false;
  return std::all_of(text.begin() + 1, text.end(), IsIdTail);
}

absl::StatusOr<MapName> MapName::Parse(std::string_view name) {
  const std::size_t infix = name.find(kMapsInfix);
  if (name.starts_with(kTenantsPrefix) && infix != std::string_view::npos) {
    const std::string_view tenant =
        name.substr(kTenantsPrefix.size(), infix - kTenantsPrefix.size());
    const std::string_view map = name.substr(infix + kMapsInfix.size());
    if (IsValidId(tenant) && IsValidId(map)) return MapName{std::string(tenant), std::string(map)};
  }
  // The message contains only the start of the name: a client may send megabytes.
  return InvalidField(reason::kBadName,
                      "name",
                      "a map's name must read tenants/{tenant}/maps/{map}, each id matching "
                      "[a-z][a-z0-9-]{0,62}; got \"" +
                          std::string(name.substr(0, 160)) + "\"");
}

std::string MapName::ToString() const {
  return std::string(kTenantsPrefix) + tenant + std::string(kMapsInfix) + map;
}

}  // namespace steadymap

#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

namespace steadymap {

/// An opaque token that says where the next page of `scope` begins: behind `position`. The scope
/// (the kind of list and what it lists) makes a token of one list useless for another.
std::string MakePageToken(std::string_view scope, std::string_view position);

/// The position in a token; empty for an empty token. Errors: `InvalidArgument` with reason
/// `BAD_PAGE_TOKEN` and the field `page_token` for anything that `MakePageToken` did not make for
/// this scope.
absl::StatusOr<std::string> ReadPageToken(std::string_view scope, std::string_view token);

/// As `ReadPageToken`, for lists whose positions are numbers; 0 for an empty token.
absl::StatusOr<std::uint64_t> ReadNumberToken(std::string_view scope, std::string_view token);

/// The size of a page: `asked`, or `standard` where that is 0. Errors: `InvalidArgument` with the
/// field `page_size` above `max`.
absl::StatusOr<std::size_t> ReadPageSize(std::uint32_t asked,
                                         std::uint32_t standard,
                                         std::uint32_t max);

}  // namespace steadymap

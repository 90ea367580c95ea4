#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>
#include <google/protobuf/message.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// Bytes of entries after which a page ends, even if it holds fewer than asked for: clients take 4
/// MiB at once unless they say otherwise, and one entry more must fit in.
inline constexpr std::size_t kMaxPageBytes = std::size_t{1} << 20;

/// An opaque token that says where the next page of `scope` begins: behind `position`. The scope
/// (the kind of list and what it lists) makes a token of one list useless for another.
std::string MakePageToken(std::string_view scope, std::string_view position);

/// The position in a token; empty for an empty token. Errors: `InvalidArgument` with reason
/// `BAD_PAGE_TOKEN` and the field `page_token` for anything that `MakePageToken` did not make for
/// this scope.
absl::StatusOr<std::string> ReadPageToken(std::string_view scope, std::string_view token);

/// As `ReadPageToken`, for lists whose positions are numbers; 0 for an empty token.
absl::StatusOr<std::uint64_t> ReadNumberToken(std::string_view scope, std::string_view token);

/// Where the next page of a listing begins that shows one revision on all its pages.
struct ListingPosition {
  std::uint64_t last = 0;  ///< Number of the last entry before.
  std::uint64_t end = 0;   ///< Number of the last entry that the first page's revision holds.
  Revision revision;       ///< Of the first page.
};

/// A token for such a position, and the position in a token; for an empty one `first`. No position
/// lies at a later revision than `first`, so that a token from before a restore of the map shows
/// what there is. Errors: as `ReadPageToken`.
std::string MakeListingToken(std::string_view scope, const ListingPosition& position);
absl::StatusOr<ListingPosition> ReadListingToken(std::string_view scope,
                                                 std::string_view token,
                                                 const ListingPosition& first);

/// The scope of a listing of a map: `list` is its kind, and what it lists are all fields of
/// `request` but `page_size` and `page_token`, so that a token goes with its filters alone.
std::string ScopeOf(std::string_view list, MapKey map, const google::protobuf::Message& request);

/// The size of a page: `asked`, or `standard` where that is 0. Errors: `InvalidArgument` with the
/// field `page_size` above `max`.
absl::StatusOr<std::size_t> ReadPageSize(std::uint32_t asked,
                                         std::uint32_t standard,
                                         std::uint32_t max);

}  // namespace steadymap

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>
#include <google/protobuf/message.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// A page ends after this many bytes of entries, even if it contains fewer entries than requested.
/// gRPC clients accept messages of 4 MiB by default, and one more entry must fit.
inline constexpr std::size_t kMaxPageBytes = std::size_t{1} << 20;

/// Makes an opaque token for the next page of `scope`, which begins after `position`. The scope
/// contains the kind of list and its filters, so that a token is valid for one list only.
std::string MakePageToken(std::string_view scope, std::string_view position);

/// Returns the position in a token; empty for an empty token. Errors: `InvalidArgument` with reason
/// `BAD_PAGE_TOKEN` and the field `page_token` for a token that `MakePageToken` did not make for
/// this scope.
absl::StatusOr<std::string> ReadPageToken(std::string_view scope, std::string_view token);

/// Reads a token of a list whose positions are numbers; 0 for an empty token. Errors: those of
/// `ReadPageToken`.
absl::StatusOr<std::uint64_t> ReadNumberToken(std::string_view scope, std::string_view token);

/// Start of the next page of a listing that shows the same revision on all pages.
struct ListingPosition {
  std::uint64_t last = 0;  ///< Number of the last entry on the previous pages.
  std::uint64_t end = 0;   ///< Number of the last entry in the revision of the first page.
  Revision revision;       ///< Revision of the first page.
};

/// Makes a token for a position, and reads the position from a token; an empty token gives `first`.
/// A position at a later revision than `first` is moved to the revision of `first`, so that a token
/// from before a restore of the map lists the existing entries. Errors: those of `ReadPageToken`.
std::string MakeListingToken(std::string_view scope, const ListingPosition& position);
absl::StatusOr<ListingPosition> ReadListingToken(std::string_view scope,
                                                 std::string_view token,
                                                 const ListingPosition& first);

/// Returns the scope of a listing of a map: the kind `list` and all fields of `request` except
/// `page_size` and `page_token`, so that a token is valid only with its filters.
std::string ScopeOf(std::string_view list, MapKey map, const google::protobuf::Message& request);

/// Returns the page size: `asked`, or `standard` if `asked` is 0. Errors: `InvalidArgument` with
/// the field `page_size` if `asked` exceeds `max`.
absl::StatusOr<std::size_t> ReadPageSize(std::uint32_t asked,
                                         std::uint32_t standard,
                                         std::uint32_t max);

}  // namespace steadymap

#include "server/rpc/page_token.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <absl/strings/escaping.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>

#include "core/types/absl_text.h"
#include "core/types/crc32c.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::size_t kChecksumDigits = 8;

std::string ChecksumOf(std::string_view scope, std::string_view position) {
  const std::uint32_t crc = ExtendCrc32c(ExtendCrc32c(0, scope), position);
  return absl::StrCat(absl::Hex(crc, absl::kZeroPad8));
}

}  // namespace

std::string MakePageToken(std::string_view scope, std::string_view position) {
  return absl::WebSafeBase64Escape(absl::StrCat(ChecksumOf(scope, position), Absl(position)));
}

absl::StatusOr<std::string> ReadPageToken(std::string_view scope, std::string_view token) {
  if (token.empty()) return std::string();
  std::string text;
  if (absl::WebSafeBase64Unescape(Absl(token), &text) && text.size() >= kChecksumDigits) {
    std::string position = text.substr(kChecksumDigits);
    if (text.substr(0, kChecksumDigits) == ChecksumOf(scope, position)) return position;
  }
  return InvalidField(
      reason::kBadPageToken, "page_token", "the page token was not issued for this list");
}

absl::StatusOr<std::uint64_t> ReadNumberToken(std::string_view scope, std::string_view token) {
  const absl::StatusOr<std::string> position = ReadPageToken(scope, token);
  if (!position.ok()) return position.status();
  std::uint64_t number = 0;
  if (position->empty() || absl::SimpleAtoi(*position, &number)) return number;
  return InvalidField(reason::kBadPageToken, "page_token", "the page token is damaged");
}

std::string MakeListingToken(std::string_view scope, const ListingPosition& position) {
  return MakePageToken(
      scope, absl::StrJoin({position.last, position.end, position.revision.value()}, "/"));
}

absl::StatusOr<ListingPosition> ReadListingToken(std::string_view scope,
                                                 std::string_view token,
                                                 const ListingPosition& first) {
  const absl::StatusOr<std::string> text = ReadPageToken(scope, token);
  if (!text.ok()) return text.status();
  if (text->empty()) return first;
  std::array<std::uint64_t, 3> numbers{};
  const std::vector<std::string> parts = absl::StrSplit(*text, '/');
  bool is_whole = parts.size() == numbers.size();
  for (std::size_t i = 0; is_whole && i < numbers.size(); ++i) {
    is_whole = absl::SimpleAtoi(parts[i], &numbers[i]);
  }
  if (!is_whole) {
    return InvalidField(reason::kBadPageToken, "page_token", "the page token is damaged");
  }
  const ListingPosition position{numbers[0], numbers[1], Revision(numbers[2])};
  if (position.revision <= first.revision) return position;
  return ListingPosition{position.last, first.end, first.revision};
}

std::string ScopeOf(std::string_view list, MapKey map, const google::protobuf::Message& request) {
  const std::unique_ptr<google::protobuf::Message> filter(request.New());
  filter->CopyFrom(request);
  filter->DiscardUnknownFields();
  for (const char* field : {"page_size", "page_token"}) {
    filter->GetReflection()->ClearField(filter.get(),
                                        filter->GetDescriptor()->FindFieldByName(field));
  }
  return absl::StrCat(Absl(list), " of ", map.value(), " ", filter->SerializeAsString());
}

absl::StatusOr<std::size_t> ReadPageSize(std::uint32_t asked,
                                         std::uint32_t standard,
                                         std::uint32_t max) {
  if (asked > max) {
    return InvalidField(reason::kBadValue,
                        "page_size",
                        absl::StrCat("page_size must be at most ", max, ", got ", asked));
  }
  return asked == 0 ? standard : asked;
}

}  // namespace steadymap

#include "server/page_token.h"

#include <cstdint>

#include <absl/strings/escaping.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include "core/absl_text.h"
#include "core/crc32c.h"
#include "core/error.h"

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
  return InvalidField(reason::kBadPageToken,
                      "page_token",
                      "the page token is not one that this list has given out");
}

absl::StatusOr<std::uint64_t> ReadNumberToken(std::string_view scope, std::string_view token) {
  const absl::StatusOr<std::string> position = ReadPageToken(scope, token);
  if (!position.ok()) return position.status();
  std::uint64_t number = 0;
  if (position->empty() || absl::SimpleAtoi(*position, &number)) return number;
  return InvalidField(reason::kBadPageToken, "page_token", "the page token is damaged");
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

#include "server/resume_token.h"

#include <array>
#include <cstddef>

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include "core/crc32c.h"
#include "core/error.h"
#include "server/history_hash.h"

namespace steadymap {
namespace {

// Version, then map, incarnation, filter, revision, event and history, then the checksum of all
// that.
constexpr char kTokenVersion = 2;
constexpr std::size_t kTokenNumbers = 6;
constexpr std::size_t kNumberBytes = 8;
constexpr std::size_t kChecksumBytes = 4;
constexpr std::size_t kTokenBytes = 1 + kTokenNumbers * kNumberBytes + kChecksumBytes;

std::uint64_t HashOf(std::string_view text) { return ExtendHash(kEmptyHash, text); }

void AppendInteger(std::uint64_t value, std::size_t bytes, std::string* text) {
  for (std::size_t i = 0; i < bytes; ++i) text->push_back(static_cast<char>(value >> (8 * i)));
}

std::uint64_t ReadInteger(std::string_view text, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    value |= std::uint64_t{static_cast<unsigned char>(text[at + i])} << (8 * i);
  }
  return value;
}

absl::Status BadToken(std::string_view field, std::string_view message) {
  return InvalidField(reason::kBadResumeToken, field, message);
}

}  // namespace

std::uint64_t FingerprintOf(const v1::WatchFilter& filter) {
  std::string bytes;
  {
    google::protobuf::io::StringOutputStream stream(&bytes);
    google::protobuf::io::CodedOutputStream coded(&stream);
    coded.SetSerializationDeterministic(true);
    filter.SerializeToCodedStream(&coded);
  }
  return HashOf(bytes);
}

std::string MakeResumeToken(const WatchScope& scope, const WatchPosition& position) {
  std::string token(1, kTokenVersion);
  const std::array<std::uint64_t, kTokenNumbers> numbers = {scope.map.value(),
                                                            HashOf(scope.incarnation),
                                                            scope.filter,
                                                            position.revision.value(),
                                                            position.last_event.value(),
                                                            position.history_hash};
  for (const std::uint64_t number : numbers) AppendInteger(number, kNumberBytes, &token);
  AppendInteger(ExtendCrc32c(0, token), kChecksumBytes, &token);
  return token;
}

absl::StatusOr<WatchPosition> ReadResumeToken(const WatchScope& scope, std::string_view token) {
  constexpr std::size_t kSummed = kTokenBytes - kChecksumBytes;
  if (token.size() != kTokenBytes || token[0] != kTokenVersion ||
      ReadInteger(token, kSummed, kChecksumBytes) != ExtendCrc32c(0, token.substr(0, kSummed))) {
    return BadToken("resume_token", "the resume token is not one that this service has given out");
  }
  std::array<std::uint64_t, kTokenNumbers> numbers{};
  for (std::size_t i = 0; i < kTokenNumbers; ++i) {
    numbers[i] = ReadInteger(token, 1 + i * kNumberBytes, kNumberBytes);
  }
  if (numbers[0] != scope.map.value() || numbers[1] != HashOf(scope.incarnation)) {
    return MakeError(absl::StatusCode::kOutOfRange,
                     reason::kRevisionCompacted,
                     "the resume token is of a map that is no more: what it knew was replaced",
                     "resume_token");
  }
  if (numbers[2] != scope.filter) {
    return BadToken("filter", "the resume token was given to a watch with another filter");
  }
  return WatchPosition{Revision(numbers[3]), EventNumber(numbers[4]), numbers[5]};
}

}  // namespace steadymap

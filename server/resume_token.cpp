#include "server/resume_token.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include "core/crc32c.h"
#include "core/error.h"
#include "proto/convert_watch.h"

namespace steadymap {
namespace {

// The version, flags, then the numbers below, then the checksum of all that.
constexpr char kTokenVersion = 2;
constexpr std::size_t kHeadBytes = 2;
constexpr std::size_t kNumberBytes = 8;
constexpr std::size_t kChecksumBytes = 4;

constexpr unsigned kHasLeaves = 1;

/// The numbers of a token, in their order.
enum Number : std::size_t {
  kMapName,
  kMapKey,
  kIncarnation,
  kFilter,
  kRevision,
  kLastEvent,
  kNumberCount
};

using Numbers = std::array<std::uint64_t, kNumberCount>;

constexpr std::size_t kTokenBytes = kHeadBytes + kNumberCount * kNumberBytes + kChecksumBytes;

/// FNV-1a.
std::uint64_t HashOf(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (const char letter : text) {
    hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001B3ULL;
  }
  return hash;
}

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

Numbers NumbersOf(const WatchScope& scope, const WatchPosition& position) {
  Numbers numbers{};
  numbers[kMapName] = HashOf(scope.map_name);
  numbers[kMapKey] = scope.map.value();
  numbers[kIncarnation] = HashOf(scope.incarnation);
  numbers[kFilter] = scope.filter;
  numbers[kRevision] = position.revision.value();
  numbers[kLastEvent] = position.last_event.value();
  return numbers;
}

absl::Status CheckFit(const Numbers& numbers, const Numbers& wanted) {
  if (numbers[kMapName] != wanted[kMapName]) {
    return BadToken("resume_token", "the resume token was given to a watch of another map");
  }
  if (numbers[kMapKey] != wanted[kMapKey] || numbers[kIncarnation] != wanted[kIncarnation]) {
    return MakeError(absl::StatusCode::kOutOfRange,
                     reason::kRevisionCompacted,
                     "the history that the resume token is of was replaced: the map was made anew",
                     "resume_token");
  }
  if (numbers[kFilter] != wanted[kFilter]) {
    return BadToken("filter", "the resume token was given to a watch with another filter");
  }
  return absl::OkStatus();
}

bool IsBefore(const Box& a, const Box& b) {
  const auto corners = [](const Box& box) {
    return std::array{
        box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z()};
  };
  return corners(a) < corners(b);
}

/// The one of all filters that let the same pass which stands for them.
MapFilter Normalize(MapFilter filter) {
  // Volumes bring the states with them.
  filter.states = filter.states || filter.volumes;
  std::vector<Box>& boxes = filter.boxes_world;
  // 0 and -0 are one place.
  for (Box& box : boxes) {
    box.min() += Eigen::Vector3d::Zero();
    box.max() += Eigen::Vector3d::Zero();
  }
  std::sort(boxes.begin(), boxes.end(), IsBefore);
  const auto is_same = [](const Box& a, const Box& b) {
    return !IsBefore(a, b) && !IsBefore(b, a);
  };
  boxes.erase(std::unique(boxes.begin(), boxes.end(), is_same), boxes.end());
  return filter;
}

}  // namespace

std::uint64_t FingerprintOf(const MapFilter& filter) {
  const v1::WatchFilter message = ToProto(Normalize(filter));
  std::string bytes;
  {
    google::protobuf::io::StringOutputStream stream(&bytes);
    google::protobuf::io::CodedOutputStream coded(&stream);
    coded.SetSerializationDeterministic(true);
    message.SerializeToCodedStream(&coded);
  }
  return HashOf(bytes);
}

std::string MakeResumeToken(const WatchScope& scope, const WatchPosition& position) {
  std::string token(1, kTokenVersion);
  AppendInteger(position.has_leaves ? kHasLeaves : 0, 1, &token);
  for (const std::uint64_t number : NumbersOf(scope, position)) {
    AppendInteger(number, kNumberBytes, &token);
  }
  AppendInteger(ExtendCrc32c(0, token), kChecksumBytes, &token);
  return token;
}

absl::StatusOr<ResumeToken> ReadResumeToken(const WatchScope& scope, std::string_view token) {
  constexpr std::size_t kSummed = kTokenBytes - kChecksumBytes;
  if (token.size() != kTokenBytes || token[0] != kTokenVersion ||
      ReadInteger(token, kSummed, kChecksumBytes) != ExtendCrc32c(0, token.substr(0, kSummed))) {
    return BadToken("resume_token", "the resume token is not one that this service has given out");
  }
  Numbers numbers{};
  for (std::size_t i = 0; i < kNumberCount; ++i) {
    numbers[i] = ReadInteger(token, kHeadBytes + i * kNumberBytes, kNumberBytes);
  }
  ResumeToken read;
  read.position = {Revision(numbers[kRevision]),
                   EventNumber(numbers[kLastEvent]),
                   (static_cast<unsigned char>(token[1]) & kHasLeaves) != 0};
  read.fit = CheckFit(numbers, NumbersOf(scope, read.position));
  return read;
}

}  // namespace steadymap

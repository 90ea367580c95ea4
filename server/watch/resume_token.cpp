#include "server/watch/resume_token.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include "core/types/crc32c.h"
#include "core/types/error.h"
#include "proto/convert_watch.h"
#include "server/store/model/history_hash.h"

namespace steadymap {
namespace {

// Layout of a token: version, flags, numbers, checksum of all bytes before it. A token between two
// steps contains only the numbers before kPositionNumbers.
constexpr char kTokenVersion = 2;
constexpr std::size_t kHeadBytes = 2;
constexpr std::size_t kNumberBytes = 8;
constexpr std::size_t kChecksumBytes = 4;

constexpr unsigned kHasLeaves = 1;
constexpr unsigned kWithinStep = 2;
constexpr unsigned kTakesPatches = 4;
constexpr unsigned kAsSnapshot = 8;
constexpr unsigned kIsShownKnown = 16;

/// The numbers of a token, in the order of the layout.
enum Number : std::size_t {
  kMapName,
  kMapKey,
  kIncarnation,
  kFilter,
  kRevision,
  kLastEvent,
  kHistory,
  kPositionNumbers,
  kStepTo = kPositionNumbers,
  kStepToHistory,
  kMaxMessageBytes,
  kPlace,
  kStepNumbers
};

using Numbers = std::array<std::uint64_t, kStepNumbers>;

constexpr std::size_t TokenBytes(std::size_t numbers) {
  return kHeadBytes + numbers * kNumberBytes + kChecksumBytes;
}

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

Numbers NumbersOf(const WatchScope& scope, const WatchPosition& position) {
  Numbers numbers{};
  numbers[kMapName] = HashOf(scope.map_name);
  numbers[kMapKey] = scope.map.value();
  numbers[kIncarnation] = HashOf(scope.incarnation);
  numbers[kFilter] = scope.filter;
  numbers[kRevision] = position.revision.value();
  numbers[kLastEvent] = position.last_event.value();
  numbers[kHistory] = position.history_hash;
  return numbers;
}

unsigned FlagsOf(const WatchPosition& position) { return position.has_leaves ? kHasLeaves : 0; }

unsigned FlagsOf(const StepKey& step) {
  return FlagsOf(step.before) | kWithinStep | (step.takes_patches ? kTakesPatches : 0) |
         (step.as_snapshot ? kAsSnapshot : 0) | (step.is_shown_known ? kIsShownKnown : 0);
}

std::string MakeToken(unsigned flags, const Numbers& numbers, std::size_t count) {
  std::string token(1, kTokenVersion);
  AppendInteger(flags, 1, &token);
  for (std::size_t i = 0; i < count; ++i) AppendInteger(numbers[i], kNumberBytes, &token);
  AppendInteger(ExtendCrc32c(0, token), kChecksumBytes, &token);
  return token;
}

absl::Status CheckFit(const Numbers& numbers, const Numbers& wanted) {
  if (numbers[kMapName] != wanted[kMapName]) {
    return BadToken("resume_token", "the resume token was issued for another map");
  }
  if (numbers[kMapKey] != wanted[kMapKey] || numbers[kIncarnation] != wanted[kIncarnation]) {
    return MakeError(absl::StatusCode::kOutOfRange,
                     reason::kRevisionCompacted,
                     "the map was recreated; the resume token is of its old history",
                     "resume_token");
  }
  if (numbers[kFilter] != wanted[kFilter]) {
    return BadToken("filter", "the resume token was issued for another filter");
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

/// Returns the canonical form of all filters that accept the same objects.
MapFilter Normalize(MapFilter filter) {
  // A filter with volumes includes the states.
  filter.states = filter.states || filter.volumes;
  std::vector<Box>& boxes = filter.boxes_world;
  // Replaces -0 by 0: both are the same coordinate.
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
  return MakeToken(FlagsOf(position), NumbersOf(scope, position), kPositionNumbers);
}

std::string MakeStepToken(const StepKey& step, std::size_t place) {
  Numbers numbers = NumbersOf(step.scope, step.before);
  numbers[kStepTo] = step.to.revision.value();
  numbers[kStepToHistory] = step.to.hash;
  numbers[kMaxMessageBytes] = step.max_message_bytes;
  numbers[kPlace] = place;
  return MakeToken(FlagsOf(step), numbers, kStepNumbers);
}

absl::StatusOr<ResumeToken> ReadResumeToken(const WatchScope& scope, std::string_view token) {
  const auto bad = BadToken("resume_token", "the resume token was not issued by this service");
  if (token.size() < TokenBytes(kPositionNumbers) || token[0] != kTokenVersion) return bad;
  const unsigned flags = static_cast<unsigned char>(token[1]);
  const std::size_t count = (flags & kWithinStep) != 0 ? kStepNumbers : kPositionNumbers;
  const std::size_t summed = TokenBytes(count) - kChecksumBytes;
  if (token.size() != TokenBytes(count) ||
      ReadInteger(token, summed, kChecksumBytes) != ExtendCrc32c(0, token.substr(0, summed))) {
    return bad;
  }
  Numbers numbers{};
  for (std::size_t i = 0; i < count; ++i) {
    numbers[i] = ReadInteger(token, kHeadBytes + i * kNumberBytes, kNumberBytes);
  }
  ResumeToken read;
  read.position = {Revision(numbers[kRevision]),
                   EventNumber(numbers[kLastEvent]),
                   numbers[kHistory],
                   (flags & kHasLeaves) != 0};
  read.fit = CheckFit(numbers, NumbersOf(scope, read.position));
  if (count == kPositionNumbers) return read;
  read.step = StepKey{scope,
                      read.position,
                      {Revision(numbers[kStepTo]), numbers[kStepToHistory]},
                      static_cast<std::size_t>(numbers[kMaxMessageBytes]),
                      (flags & kTakesPatches) != 0,
                      (flags & kAsSnapshot) != 0,
                      (flags & kIsShownKnown) != 0};
  read.place = static_cast<std::size_t>(numbers[kPlace]);
  return read;
}

}  // namespace steadymap

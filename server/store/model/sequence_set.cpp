#include "server/store/model/sequence_set.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();

// Seven bits per byte, lowest bits first; the top bit is set on all bytes but the last.
void AppendVarint(std::uint64_t value, std::string* packed) {
  while (value >= 0x80U) {
    packed->push_back(static_cast<char>((value & 0x7FU) | 0x80U));
    value >>= 7;
  }
  packed->push_back(static_cast<char>(value));
}

// Removes a varint from the front; none if there is no complete varint that fits 64 bits.
std::optional<std::uint64_t> TakeVarint(std::string_view* packed) {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    if (packed->empty()) return std::nullopt;
    const auto byte = static_cast<unsigned char>(packed->front());
    packed->remove_prefix(1);
    if (shift == 63 && byte > 1) return std::nullopt;
    value |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
    if ((byte & 0x80U) == 0) return value;
  }
  return std::nullopt;
}

absl::Status Damaged() {
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   "the stored bytes are not a packed set of client sequences");
}

}  // namespace

bool SequenceSet::Contains(ClientSequence sequence) const {
  const auto after = intervals_.upper_bound(sequence);
  return after != intervals_.begin() && std::prev(after)->second >= sequence;
}

absl::Status SequenceSet::Insert(ClientSequence sequence) {
  if (sequence.value() == 0) {
    return InvalidField(reason::kBadSequence, "client_seq", "client sequences start at 1, got 0");
  }
  const auto after = intervals_.upper_bound(sequence);
  const auto before = after == intervals_.begin() ? intervals_.end() : std::prev(after);
  if (before != intervals_.end() && before->second >= sequence) return absl::OkStatus();
  const bool joins_before = before != intervals_.end() && before->second.Next() == sequence;
  const bool joins_after = after != intervals_.end() && sequence.Next() == after->first;
  if (!joins_before && !joins_after && intervals_.size() >= kMaxIntervals) {
    return InvalidField(reason::kBadSequence,
                        "client_seq",
                        absl::StrCat("client sequence ",
                                     sequence.value(),
                                     " would leave more than ",
                                     kMaxIntervals - 1,
                                     " gaps; first send the missing client sequences from ",
                                     contiguous_end().value() + 1,
                                     " on"));
  }
  const ClientSequence last = joins_after ? after->second : sequence;
  if (joins_after) intervals_.erase(after);
  if (joins_before) {
    before->second = last;
  } else {
    intervals_.emplace(sequence, last);
  }
  return absl::OkStatus();
}

void SequenceSet::InsertThrough(ClientSequence last) {
  if (last.value() == 0) return;
  auto after = intervals_.begin();
  ClientSequence end = last;
  // All intervals that start within 1..last+1 are merged into the first interval.
  while (after != intervals_.end() && after->first.value() - 1 <= last.value()) {
    end = std::max(end, after->second);
    after = intervals_.erase(after);
  }
  intervals_.emplace(ClientSequence{1}, end);
}

ClientSequence SequenceSet::contiguous_end() const {
  if (intervals_.empty() || intervals_.begin()->first.value() != 1) return ClientSequence{};
  return intervals_.begin()->second;
}

ClientSequence SequenceSet::max() const {
  return intervals_.empty() ? ClientSequence{} : intervals_.rbegin()->second;
}

// The number of intervals; then for each interval the distance of its first sequence from the last
// sequence of the previous interval, and the distance of its last sequence from its first.
std::string SequenceSet::Pack() const {
  std::string packed;
  AppendVarint(intervals_.size(), &packed);
  std::uint64_t end = 0;
  for (const auto& [first, last] : intervals_) {
    AppendVarint(first.value() - end, &packed);
    AppendVarint(last.value() - first.value(), &packed);
    end = last.value();
  }
  return packed;
}

absl::StatusOr<SequenceSet> SequenceSet::Unpack(std::string_view packed) {
  const std::optional<std::uint64_t> count = TakeVarint(&packed);
  if (!count || *count > kMaxIntervals) return Damaged();
  SequenceSet set;
  std::uint64_t end = 0;
  for (std::uint64_t i = 0; i < *count; ++i) {
    const std::optional<std::uint64_t> step = TakeVarint(&packed);
    const std::optional<std::uint64_t> more = TakeVarint(&packed);
    // A step of 1 would make the intervals adjacent: `Pack` never writes that.
    const std::uint64_t least_step = i == 0 ? 1 : 2;
    if (!step || !more || *step < least_step || *step > kLargest - end) return Damaged();
    const std::uint64_t first = end + *step;
    if (*more > kLargest - first) return Damaged();
    end = first + *more;
    set.intervals_.emplace_hint(set.intervals_.end(), ClientSequence{first}, ClientSequence{end});
  }
  if (!packed.empty()) return Damaged();
  return set;
}

}  // namespace steadymap

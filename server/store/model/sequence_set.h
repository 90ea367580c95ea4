#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// A set of client sequences, kept as intervals: a session that sends its frames in order takes
/// one, however long it lasts.
class SequenceSet {
 public:
  /// Most intervals of a set. A client that leaves more gaps than this open is refused.
  static constexpr std::size_t kMaxIntervals = 1024;

  bool Contains(ClientSequence sequence) const;

  /// Adds one. Errors: `InvalidArgument` with reason `BAD_SEQUENCE` for 0 and for one gap too many;
  /// the set is then unchanged.
  absl::Status Insert(ClientSequence sequence);

  /// Adds all from 1 to `last`, closing every gap below.
  void InsertThrough(ClientSequence last);

  /// The largest s such that all of 1..s are in the set; 0 if 1 is not.
  ClientSequence contiguous_end() const;

  /// The largest in the set; 0 if it is empty.
  ClientSequence max() const;

  std::size_t interval_count() const { return intervals_.size(); }

  /// A packed form for the store, and back. Errors: `DataLoss` if `packed` is none.
  std::string Pack() const;
  static absl::StatusOr<SequenceSet> Unpack(std::string_view packed);

  friend bool operator==(const SequenceSet&, const SequenceSet&) = default;

 private:
  /// First to last of each interval, disjoint and not adjacent.
  std::map<ClientSequence, ClientSequence> intervals_;
};

}  // namespace steadymap

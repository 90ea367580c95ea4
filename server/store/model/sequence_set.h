#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// A set of client sequences, stored as intervals. A session that sends its frames in order needs
/// one interval, however long it lasts.
class SequenceSet {
 public:
  /// Largest number of intervals in a set. A client that leaves more gaps is refused.
  static constexpr std::size_t kMaxIntervals = 1024;

  bool Contains(ClientSequence sequence) const;

  /// Adds one sequence. Errors: `InvalidArgument` with reason `BAD_SEQUENCE` for 0, and if it would
  /// open one gap too many. After an error the set is unchanged.
  absl::Status Insert(ClientSequence sequence);

  /// Adds all sequences from 1 to `last`, so that no gap below `last` remains.
  void InsertThrough(ClientSequence last);

  /// Returns the largest s such that all of 1..s are in the set; 0 if 1 is not in the set.
  ClientSequence contiguous_end() const;

  /// Returns the largest sequence in the set; 0 if the set is empty.
  ClientSequence max() const;

  std::size_t interval_count() const { return intervals_.size(); }

  /// Converts a set to its stored form. `Unpack` converts back. Error of `Unpack`: `DataLoss` if
  /// `packed` is not the stored form of a set.
  std::string Pack() const;
  static absl::StatusOr<SequenceSet> Unpack(std::string_view packed);

  friend bool operator==(const SequenceSet&, const SequenceSet&) = default;

 private:
  /// First and last sequence of each interval. The intervals are disjoint and not adjacent.
  std::map<ClientSequence, ClientSequence> intervals_;
};

}  // namespace steadymap

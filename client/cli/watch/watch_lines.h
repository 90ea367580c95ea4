#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "client/cli/query/object_text.h"
#include "client/watch/watch_sequence.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/event.pb.h"
#include "steadymap/v1/object.pb.h"
#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// The number of leaves of a volume that changed in a step.
struct LeafCounts {
  std::uint64_t changed = 0;  ///< Includes new leaves.
  std::uint64_t gone = 0;
};

/// The changed leaves of a step by object; 0 is the background.
using VolumeChange = std::map<std::uint64_t, LeafCounts>;

/// Formats the messages of a watch as lines, each with its line feed: readable text, or JSON
/// documents with a `kind`.
class WatchLines {
 public:
  /// `classes` must outlive the lines.
  WatchLines(const ClassNames* classes, bool as_json) : classes_(*classes), as_json_(as_json) {}

  std::string Created(const v1::WatchCreated& created) const;

  std::string Event(const v1::ObjectEvent& event) const;

  /// Formats the new state of an object at `revision`.
  std::string Object(Revision revision, const v1::Object& object) const;

  /// Formats the removal of an object that is no longer shown.
  std::string Removed(Revision revision, std::uint64_t object) const;

  std::string Volume(const WatchStep& step, const VolumeChange& change) const;

  /// Formats a resync, which invalidates all previous content.
  std::string Resync(Revision revision, std::string_view reason) const;

  std::string Progress(const WatchStep& step) const;

 private:
  const ClassNames& classes_;
  const bool as_json_;
};

}  // namespace steadymap

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/map/map_snapshot.h"

#include "steadymap/v1/watch_service.pb.h"

/// Messages of a server on a watch.
namespace steadymap::watching {

using Messages = std::vector<v1::WatchMapResponse>;

/// Concatenates messages.
Messages Join(const std::vector<Messages>& parts);

Messages Created(const MapSnapshot& map, const std::string& incarnation = "first");

/// Returns a whole map in chunks of at most `max_leaves` leaves; without its progress.
Messages SnapshotOf(const MapSnapshot& map, std::size_t max_leaves = 20);

/// Returns the delta from one map to another in `fragments` fragments; without its progress.
Messages DeltaOf(const MapSnapshot& before, const MapSnapshot& after, std::uint32_t fragments = 1);

/// Returns events with these numbers, all at `revision`.
Messages Events(std::uint64_t revision, const std::vector<std::uint64_t>& numbers);

/// Returns the progress to `revision`. The newest frame of revision r has the capture time 10 r
/// seconds.
Messages Progress(std::uint64_t revision, const std::string& token);

Messages Resync(std::uint64_t revision);

Messages Goodbye(std::int64_t reconnect_after_s);

/// The content of a map that clients receive, for comparison: objects and leaves, serialized.
struct MapContent {
  std::uint64_t revision = 0;
  std::map<std::uint64_t, std::string> objects;
  std::map<LeafKey, std::string> leaves;

  friend bool operator==(const MapContent&, const MapContent&) = default;
};

MapContent ContentOf(const MapSnapshot& map);

/// A floor at revision 5 with the present objects 1 and 2.
MapSnapshot FirstMap();

/// `FirstMap` at revision 6: object 1 was removed, 2 has another belief, 3 was added, and the floor
/// gained a leaf and lost one.
MapSnapshot SecondMap();

}  // namespace steadymap::watching

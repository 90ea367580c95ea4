#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/map/map_snapshot.h"

#include "steadymap/v1/watch_service.pb.h"

/// What a server would send on a watch.
namespace steadymap::watching {

using Messages = std::vector<v1::WatchMapResponse>;

/// One after the other.
Messages Join(const std::vector<Messages>& parts);

Messages Created(const MapSnapshot& map, const std::string& incarnation = "first");

/// All of a map, in pieces of at most `max_leaves` leaves; without its progress.
Messages SnapshotOf(const MapSnapshot& map, std::size_t max_leaves = 20);

/// What takes one map to another, in so many fragments; without its progress.
Messages DeltaOf(const MapSnapshot& before, const MapSnapshot& after, std::uint32_t fragments = 1);

/// Events with these numbers, all at `revision`.
Messages Events(std::uint64_t revision, const std::vector<std::uint64_t>& numbers);

/// The newest frame of revision r is of second 10 r.
Messages Progress(std::uint64_t revision, const std::string& token);

Messages Resync(std::uint64_t revision);

Messages Goodbye(std::int64_t reconnect_after_s);

/// What a client can know of a map, to be compared: objects and leaves, serialized.
struct MapContent {
  std::uint64_t revision = 0;
  std::map<std::uint64_t, std::string> objects;
  std::map<LeafKey, std::string> leaves;

  friend bool operator==(const MapContent&, const MapContent&) = default;
};

MapContent ContentOf(const MapSnapshot& map);

/// A floor at revision 5 with the present objects 1 and 2.
MapSnapshot FirstMap();

/// The same at revision 6: object 1 went, 2 believes something else, 3 came, and the floor got a
/// leaf and lost one.
MapSnapshot SecondMap();

}  // namespace steadymap::watching

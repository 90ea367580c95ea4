#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/store/model/store.h"

/// Content for the tests of the store.
namespace steadymap {

/// Time of the store's tests, in uptime of the map.
inline constexpr MapUptime kStoreTime = std::chrono::seconds(1000);

/// Sensor of the frames in the store's tests.
inline const SensorName kStoreSensor{"robot-1", "camera"};

/// Returns a map record with non-default values in every field.
MapRecord MakeMapRecord(const std::string& tenant, const std::string& map);

/// Returns a frame with all fields derived from its sequence and `bytes` incompressible bytes.
LogEntry MakeLogEntry(std::uint64_t sequence, std::size_t bytes = 64);

/// Returns the pose of the frame of `MakeLogEntry`.
FramePose MakePose(std::uint64_t sequence);

/// Returns an append of `count` frames from `first` on, from one session.
LogAppend MakeAppend(MapKey map,
                     std::uint64_t first,
                     std::uint64_t count,
                     MapUptime uptime = kStoreTime);

/// Returns a session that settled 1..`settled`.
SessionRecord MakeSession(const std::string& session,
                          std::uint64_t settled,
                          MapUptime last_active = kStoreTime);

/// Returns the details of a commit of `delta`: the poses of its frames.
CommitDetails MakeDetails(const MapDelta& delta, MapUptime uptime = kStoreTime);

/// Returns a leaf of voxels derived from `seed`, at the given leaf index on each axis.
LeafChange MakeLeaf(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed);

/// Returns the state of an object with all fields derived from `seed`.
ObjectState MakeObject(std::uint64_t id, std::uint32_t seed);

/// Returns an event with all fields derived from `seed`.
ObjectEvent MakeEvent(EventType type, std::uint64_t object, std::uint32_t seed);

/// Returns the state of a robot with all fields derived from `seed`.
RobotState MakeRobot(Trust trust, std::uint32_t seed);

/// Returns a delta with these leaves, sorted.
MapDelta MakeDelta(std::uint64_t from, std::uint64_t to, std::vector<LeafChange> leaves);

/// Returns all leaves of a snapshot, packed.
std::vector<LeafChange> LeavesOf(const MapSnapshot& snapshot);

bool SameEntry(const LogEntry& a, const LogEntry& b);

/// Returns the entries of the log from `first` on; a failed read fails the test.
std::vector<LogEntry> ReadAll(Store* store, MapKey map, std::uint64_t first = 1);

}  // namespace steadymap

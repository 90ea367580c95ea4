#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/store/model/store.h"

/// What the store's tests put into it.
namespace steadymap {

/// When the store's tests take place, by the map's uptime.
inline constexpr MapUptime kStoreTime = std::chrono::seconds(1000);

/// What takes the frames of the store's tests.
inline const SensorName kStoreSensor{"robot-1", "camera"};

/// A map record with every field set to something that is not the default.
MapRecord MakeMapRecord(const std::string& tenant, const std::string& map);

/// A frame whose every field follows from its sequence: `bytes` bytes that do not compress.
LogEntry MakeLogEntry(std::uint64_t sequence, std::size_t bytes = 64);

/// Where that frame was taken.
FramePose MakePose(std::uint64_t sequence);

/// `count` frames from `first` on, as one append of one session.
LogAppend MakeAppend(MapKey map,
                     std::uint64_t first,
                     std::uint64_t count,
                     MapUptime uptime = kStoreTime);

/// A session that settled 1..`settled`.
SessionRecord MakeSession(const std::string& session,
                          std::uint64_t settled,
                          MapUptime last_active = kStoreTime);

/// What a commit brings besides `delta`: the poses of its frames.
CommitDetails MakeDetails(const MapDelta& delta, MapUptime uptime = kStoreTime);

/// A leaf of canonical voxels that follow from `seed`, at the given leaf index on each axis.
LeafChange MakeLeaf(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed);

/// The state of an object, every field of which follows from `seed`.
ObjectState MakeObject(std::uint64_t id, std::uint32_t seed);

/// An event, likewise.
ObjectEvent MakeEvent(EventType type, std::uint64_t object, std::uint32_t seed);

/// What is remembered of a robot, likewise.
RobotState MakeRobot(Trust trust, std::uint32_t seed);

/// A delta with these leaves, sorted.
MapDelta MakeDelta(std::uint64_t from, std::uint64_t to, std::vector<LeafChange> leaves);

/// All leaves of a snapshot, packed.
std::vector<LeafChange> LeavesOf(const MapSnapshot& snapshot);

bool SameEntry(const LogEntry& a, const LogEntry& b);

/// The entries of the log from `first` on; a failed read fails the test.
std::vector<LogEntry> ReadAll(Store* store, MapKey map, std::uint64_t first = 1);

}  // namespace steadymap

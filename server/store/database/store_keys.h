#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/map/map_delta.h"
#include "core/types/identifiers.h"
#include "server/store/database/state_database.h"
#include "server/store/model/store.h"

/// The keys of a map's database. All integers are big-endian, so that keys sort in numerical order;
/// signed integers have their sign bit flipped. A key starts with the letter of its family. Leaf
/// keys have no letter, because leaves have their own column family.
namespace steadymap {

/// A range of keys: `begin` <= key < `end`.
struct KeyRange {
  std::string begin;
  std::string end;
};

/// Returns the range of all keys of a family. The range of leaves excludes the largest possible
/// object id.
KeyRange RangeOf(Family family);

/// Returns the number in a key of `pose`, `change`, `object` or `event`; none for any other key.
std::optional<std::uint64_t> NumberOfKey(std::string_view key);

/// Key of `pose`: sequence. `SequenceOfPoseKey` returns the sequence; none for any other key.
std::string PoseKey(MapSequence sequence);
std::optional<MapSequence> SequenceOfPoseKey(std::string_view key);

/// Key of `change`: revision.
std::string ChangeKey(Revision revision);

/// Key of `session`: robot, a zero byte, sensor, a zero byte, session. The ids must not contain a
/// zero byte.
std::string SessionKey(const SessionName& name);

/// Key of `leaf`: object and origin of a leaf, 20 bytes. `UnpackLeafKey` converts back; none if
/// `packed` is not such a key.
inline constexpr std::size_t kPackedLeafKeyBytes = 20;
std::string PackLeafKey(const LeafKey& leaf);
std::optional<LeafKey> UnpackLeafKey(std::string_view packed);

/// Key of `object`: object. `ObjectOfKey` returns the object; none for any other key.
std::string ObjectKey(ObjectId object);
std::optional<ObjectId> ObjectOfKey(std::string_view key);

/// Key of `event`: number. `EventOfKey` returns the number; none for any other key.
std::string EventKey(EventNumber number);
std::optional<EventNumber> EventOfKey(std::string_view key);

/// Key of `free`: origin. `FreeBlockOfKey` returns the origin; none for any other key.
std::string FreeBlockKey(LeafOrigin origin);
std::optional<LeafOrigin> FreeBlockOfKey(std::string_view key);

/// Key of `robot`: robot, a zero byte, sensor. `SensorOfRobotKey` returns the sensor; none for any
/// other key.
std::string RobotKey(const SensorName& sensor);
std::optional<SensorName> SensorOfRobotKey(std::string_view key);

/// Keys of `meta`: the head of the map, and its class table, which exists only if classes were
/// added.
std::string HeadKey();
std::string ClassTableKey();

/// Returns a key in hexadecimal, for error messages.
std::string KeyAsHex(std::string_view key);

}  // namespace steadymap

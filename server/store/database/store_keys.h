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

/// The keys of a map's database. All integers are big-endian, so that keys sort as numbers do;
/// signed ones have their sign bit flipped. A key starts with the letter of its family; those of
/// leaves, which have a column family of their own, with none.
namespace steadymap {

/// A range of keys: `begin` <= key < `end`.
struct KeyRange {
  std::string begin;
  std::string end;
};

/// All keys of a family; of leaves: all that a leaf of an object with an id below the largest can
/// have.
KeyRange RangeOf(Family family);

/// The number in a key of `pose`, `change`, `object` or `event`; none if `key` is no such key.
std::optional<std::uint64_t> NumberOfKey(std::string_view key);

/// `pose`: sequence; and the sequence in such a key, none if `key` is no such key.
std::string PoseKey(MapSequence sequence);
std::optional<MapSequence> SequenceOfPoseKey(std::string_view key);

/// `change`: revision.
std::string ChangeKey(Revision revision);

/// `session`: robot, a zero byte, sensor, a zero byte, session. The ids must hold no zero byte.
std::string SessionKey(const SessionName& name);

/// `leaf`: object and origin of a leaf, 20 bytes, and back; none if `packed` is no such thing.
inline constexpr std::size_t kPackedLeafKeyBytes = 20;
std::string PackLeafKey(const LeafKey& leaf);
std::optional<LeafKey> UnpackLeafKey(std::string_view packed);

/// `object`: object; and the object in such a key, none if `key` is no such key.
std::string ObjectKey(ObjectId object);
std::optional<ObjectId> ObjectOfKey(std::string_view key);

/// `event`: number; and the number in such a key, none if `key` is no such key.
std::string EventKey(EventNumber number);
std::optional<EventNumber> EventOfKey(std::string_view key);

/// `free`: origin; and the origin in such a key, none if `key` is no such key.
std::string FreeBlockKey(LeafOrigin origin);
std::optional<LeafOrigin> FreeBlockOfKey(std::string_view key);

/// `robot`: robot, a zero byte, sensor; and the sensor in such a key, none if `key` is no such key.
std::string RobotKey(const SensorName& sensor);
std::optional<SensorName> SensorOfRobotKey(std::string_view key);

/// `meta`: the head of the map, and its class table where it has gained classes.
std::string HeadKey();
std::string ClassTableKey();

/// A key as a person may read it in an error: hexadecimal.
std::string KeyForPeople(std::string_view key);

}  // namespace steadymap

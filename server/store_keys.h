#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/identifiers.h"
#include "core/map_delta.h"
#include "server/store.h"

/// The keys of the store. All integers are big-endian, so that keys sort as numbers do; signed ones
/// have their sign bit flipped. Every key that belongs to a map starts with the map's `MapKey`,
/// never with its name: what a deleted map left cannot turn up in a new map of the same name.
namespace steadymap {

/// A range of keys: `begin` <= key < `end`.
struct KeyRange {
  std::string begin;
  std::string end;
};

/// Every column family but `meta`: everything of one map. The largest
/// `MapKey` is never given to a map.
KeyRange MapRange(MapKey map);

/// The number behind the map in a key of `log`, `pose`, `change`, `object` or `event`; none if
/// `key` is no such key.
std::optional<std::uint64_t> NumberOfKey(std::string_view key);

/// `log` and `pose`: map, sequence.
std::string FrameKey(MapKey map, MapSequence sequence);

/// The sequence in a key made by `FrameKey`; none if `key` is no such key.
std::optional<MapSequence> SequenceOfFrameKey(std::string_view key);

/// `change`: map, revision.
std::string ChangeKey(MapKey map, Revision revision);

/// `dedup`: map, robot, a zero byte, session. The ids must hold no zero byte.
std::string SessionKey(MapKey map, const SessionName& name);

/// `leaf`: map, then the 20 bytes of `PackLeafKey`.
std::string LeafStoreKey(MapKey map, const LeafKey& leaf);

/// Object and origin of a leaf, 20 bytes, and back; none if `packed` is no such thing.
inline constexpr std::size_t kPackedLeafKeyBytes = 20;
std::string PackLeafKey(const LeafKey& leaf);
std::optional<LeafKey> UnpackLeafKey(std::string_view packed);

/// The leaf in a key made by `LeafStoreKey`; none if `key` is no such key.
std::optional<LeafKey> LeafOfStoreKey(std::string_view key);

/// `object`: map, object; and the object in such a key, none if `key` is no such key.
std::string ObjectKey(MapKey map, ObjectId object);
std::optional<ObjectId> ObjectOfKey(std::string_view key);

/// `event`: map, number; and the number in such a key, none if `key` is no such key.
std::string EventKey(MapKey map, EventNumber number);
std::optional<EventNumber> EventOfKey(std::string_view key);

/// `free`: map, origin; and the origin in such a key, none if `key` is no such key.
std::string FreeBlockKey(MapKey map, LeafOrigin origin);
std::optional<LeafOrigin> FreeBlockOfKey(std::string_view key);

/// `robot`: map, robot; and the robot in such a key, none if `key` is no such key.
std::string RobotKey(MapKey map, const std::string& robot);
std::optional<std::string> RobotOfKey(std::string_view key);

/// `meta`: one letter, then the map.
std::string MapRecordKey(MapKey map);
std::string LogHeadKey(MapKey map);
std::string RevisionHeadKey(MapKey map);

/// `meta`: the next `MapKey` to give away.
std::string NextMapKeyKey();

/// `meta`: a letter, then the name; sorted as the names are.
std::string NameIndexKey(const MapName& name);
std::string NameIndexPrefix();

/// The name in a key made by `NameIndexKey`; none if `key` is no such key.
std::optional<MapName> NameOfIndexKey(std::string_view key);

/// A key as a person may read it in an error: hexadecimal.
std::string KeyForPeople(std::string_view key);

}  // namespace steadymap

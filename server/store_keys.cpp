#include "server/store_keys.h"

#include <absl/strings/escaping.h>

namespace steadymap {
namespace {

constexpr std::size_t kMapKeyBytes = 8;
constexpr std::size_t kNumberKeyBytes = 16;
constexpr std::size_t kOriginBytes = 12;
constexpr char kMapRecordLetter = 'm';
constexpr char kLogHeadLetter = 'h';
constexpr char kRevisionHeadLetter = 'r';
constexpr char kNameIndexLetter = 'n';
constexpr char kNextMapKeyLetter = 'k';

template <typename Integer>
void AppendBigEndian(Integer value, std::string* key) {
  for (int shift = 8 * (static_cast<int>(sizeof(Integer)) - 1); shift >= 0; shift -= 8) {
    key->push_back(static_cast<char>(static_cast<unsigned char>(value >> shift)));
  }
}

template <typename Integer>
Integer ReadBigEndian(std::string_view bytes) {
  Integer value = 0;
  for (std::size_t i = 0; i < sizeof(Integer); ++i) {
    value = static_cast<Integer>((value << 8) | static_cast<unsigned char>(bytes[i]));
  }
  return value;
}

void AppendCoordinate(std::int32_t value, std::string* key) {
  AppendBigEndian(static_cast<std::uint32_t>(value) ^ 0x80000000U, key);
}

std::int32_t ReadCoordinate(std::string_view bytes) {
  return static_cast<std::int32_t>(ReadBigEndian<std::uint32_t>(bytes) ^ 0x80000000U);
}

void AppendOrigin(LeafOrigin origin, std::string* key) {
  AppendCoordinate(origin.x, key);
  AppendCoordinate(origin.y, key);
  AppendCoordinate(origin.z, key);
}

/// The origin in the first twelve bytes; none if it is no origin.
std::optional<LeafOrigin> ReadOrigin(std::string_view bytes) {
  const LeafOrigin origin{
      ReadCoordinate(bytes), ReadCoordinate(bytes.substr(4)), ReadCoordinate(bytes.substr(8))};
  if (origin != LeafOf(origin.x, origin.y, origin.z)) return std::nullopt;
  return origin;
}

std::string MapPrefix(MapKey map) {
  std::string key;
  AppendBigEndian(map.value(), &key);
  return key;
}

std::string NumberKey(MapKey map, std::uint64_t number) {
  std::string key = MapPrefix(map);
  AppendBigEndian(number, &key);
  return key;
}

template <typename Number>
std::optional<Number> StrongNumberOfKey(std::string_view key) {
  const std::optional<std::uint64_t> number = NumberOfKey(key);
  return number ? std::optional<Number>(Number{*number}) : std::nullopt;
}

std::string MetaKey(char letter, MapKey map) { return letter + MapPrefix(map); }

}  // namespace

KeyRange MapRange(MapKey map) { return {MapPrefix(map), MapPrefix(map.Next())}; }

std::optional<std::uint64_t> NumberOfKey(std::string_view key) {
  if (key.size() != kNumberKeyBytes) return std::nullopt;
  return ReadBigEndian<std::uint64_t>(key.substr(kMapKeyBytes));
}

std::string FrameKey(MapKey map, MapSequence sequence) { return NumberKey(map, sequence.value()); }

std::optional<MapSequence> SequenceOfFrameKey(std::string_view key) {
  return StrongNumberOfKey<MapSequence>(key);
}

std::string ChangeKey(MapKey map, Revision revision) { return NumberKey(map, revision.value()); }

std::string ObjectKey(MapKey map, ObjectId object) { return NumberKey(map, object.value()); }

std::optional<ObjectId> ObjectOfKey(std::string_view key) {
  return StrongNumberOfKey<ObjectId>(key);
}

std::string EventKey(MapKey map, EventNumber number) { return NumberKey(map, number.value()); }

std::optional<EventNumber> EventOfKey(std::string_view key) {
  return StrongNumberOfKey<EventNumber>(key);
}

std::string FreeBlockKey(MapKey map, LeafOrigin origin) {
  std::string key = MapPrefix(map);
  AppendOrigin(origin, &key);
  return key;
}

std::optional<LeafOrigin> FreeBlockOfKey(std::string_view key) {
  if (key.size() != kMapKeyBytes + kOriginBytes) return std::nullopt;
  return ReadOrigin(key.substr(kMapKeyBytes));
}

std::string RobotKey(MapKey map, const std::string& robot) { return MapPrefix(map) + robot; }

std::optional<std::string> RobotOfKey(std::string_view key) {
  if (key.size() < kMapKeyBytes) return std::nullopt;
  return std::string(key.substr(kMapKeyBytes));
}

std::string SessionKey(MapKey map, const SessionName& name) {
  return MapPrefix(map) + name.robot + '\0' + name.session;
}

std::string LeafStoreKey(MapKey map, const LeafKey& leaf) {
  return MapPrefix(map) + PackLeafKey(leaf);
}

std::string PackLeafKey(const LeafKey& leaf) {
  std::string key;
  key.reserve(kPackedLeafKeyBytes);
  AppendBigEndian(leaf.object.value(), &key);
  AppendOrigin(leaf.origin, &key);
  return key;
}

std::optional<LeafKey> UnpackLeafKey(std::string_view packed) {
  if (packed.size() != kPackedLeafKeyBytes) return std::nullopt;
  const std::optional<LeafOrigin> origin = ReadOrigin(packed.substr(8));
  if (!origin) return std::nullopt;
  return LeafKey{ObjectId{ReadBigEndian<std::uint64_t>(packed)}, *origin};
}

std::optional<LeafKey> LeafOfStoreKey(std::string_view key) {
  if (key.size() < kMapKeyBytes) return std::nullopt;
  return UnpackLeafKey(key.substr(kMapKeyBytes));
}

std::string MapRecordKey(MapKey map) { return MetaKey(kMapRecordLetter, map); }

std::string LogHeadKey(MapKey map) { return MetaKey(kLogHeadLetter, map); }

std::string RevisionHeadKey(MapKey map) { return MetaKey(kRevisionHeadLetter, map); }

std::string NextMapKeyKey() { return {kNextMapKeyLetter}; }

std::string NameIndexPrefix() { return {kNameIndexLetter}; }

// A zero byte between the ids sorts "a" before "a-b" whatever follows, as comparing pairs does.
std::string NameIndexKey(const MapName& name) {
  return NameIndexPrefix() + name.tenant + '\0' + name.map;
}

std::optional<MapName> NameOfIndexKey(std::string_view key) {
  const std::size_t border = key.find('\0');
  if (key.empty() || key.front() != kNameIndexLetter || border == std::string_view::npos) {
    return std::nullopt;
  }
  return MapName{std::string(key.substr(1, border - 1)), std::string(key.substr(border + 1))};
}

std::string KeyForPeople(std::string_view key) {
  return absl::BytesToHexString(absl::string_view(key.data(), key.size()));
}

}  // namespace steadymap

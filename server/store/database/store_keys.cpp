#include "server/store/database/store_keys.h"

#include <array>

#include <absl/strings/escaping.h>

namespace steadymap {
namespace {

constexpr std::size_t kNumberKeyBytes = 9;
constexpr std::size_t kOriginBytes = 12;

/// The letter of each `Family`; leaves have none.
constexpr std::array<char, kFamilyNames.size()> kLetters = {
    '\0', 's', 'o', 'e', 'f', 'r', 'c', 'p', 'm'};

constexpr char LetterOf(Family family) { return kLetters[static_cast<std::size_t>(family)]; }

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

/// Returns the origin in the first twelve bytes; none if they are not the origin of a leaf.
std::optional<LeafOrigin> ReadOrigin(std::string_view bytes) {
  const LeafOrigin origin{
      ReadCoordinate(bytes), ReadCoordinate(bytes.substr(4)), ReadCoordinate(bytes.substr(8))};
  if (origin != LeafOf(origin.x, origin.y, origin.z)) return std::nullopt;
  return origin;
}

std::string NumberKey(Family family, std::uint64_t number) {
  std::string key(1, LetterOf(family));
  AppendBigEndian(number, &key);
  return key;
}

template <typename Number>
std::optional<Number> StrongNumberOfKey(Family family, std::string_view key) {
  if (key.empty() || key.front() != LetterOf(family)) return std::nullopt;
  const std::optional<std::uint64_t> number = NumberOfKey(key);
  return number ? std::optional<Number>(Number{*number}) : std::nullopt;
}

}  // namespace

KeyRange RangeOf(Family family) {
  if (family == Family::kLeaf) return {std::string(), std::string(8, '\xFF')};
  const char letter = LetterOf(family);
  return {std::string(1, letter), std::string(1, static_cast<char>(letter + 1))};
}

std::optional<std::uint64_t> NumberOfKey(std::string_view key) {
  if (key.size() != kNumberKeyBytes) return std::nullopt;
  return ReadBigEndian<std::uint64_t>(key.substr(1));
}

std::string PoseKey(MapSequence sequence) { return NumberKey(Family::kPose, sequence.value()); }

std::optional<MapSequence> SequenceOfPoseKey(std::string_view key) {
  return StrongNumberOfKey<MapSequence>(Family::kPose, key);
}

std::string ChangeKey(Revision revision) { return NumberKey(Family::kChange, revision.value()); }

std::string ObjectKey(ObjectId object) { return NumberKey(Family::kObject, object.value()); }

std::optional<ObjectId> ObjectOfKey(std::string_view key) {
  return StrongNumberOfKey<ObjectId>(Family::kObject, key);
}

std::string EventKey(EventNumber number) { return NumberKey(Family::kEvent, number.value()); }

std::optional<EventNumber> EventOfKey(std::string_view key) {
  return StrongNumberOfKey<EventNumber>(Family::kEvent, key);
}

std::string FreeBlockKey(LeafOrigin origin) {
  std::string key(1, LetterOf(Family::kFree));
  AppendOrigin(origin, &key);
  return key;
}

std::optional<LeafOrigin> FreeBlockOfKey(std::string_view key) {
  if (key.size() != 1 + kOriginBytes || key.front() != LetterOf(Family::kFree)) return std::nullopt;
  return ReadOrigin(key.substr(1));
}

// A zero byte between the ids sorts "a" before "a-b" whatever follows, as a comparison of the ids
// does.
std::string RobotKey(const SensorName& sensor) {
  return LetterOf(Family::kRobot) + sensor.robot + '\0' + sensor.sensor;
}

std::optional<SensorName> SensorOfRobotKey(std::string_view key) {
  const std::size_t border = key.find('\0');
  if (key.empty() || key.front() != LetterOf(Family::kRobot) || border == std::string_view::npos) {
    return std::nullopt;
  }
  return SensorName{std::string(key.substr(1, border - 1)), std::string(key.substr(border + 1))};
}

std::string SessionKey(const SessionName& name) {
  return LetterOf(Family::kSession) + name.sensor.robot + '\0' + name.sensor.sensor + '\0' +
         name.session;
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

std::string HeadKey() { return std::string(1, LetterOf(Family::kMeta)) + 'h'; }

std::string ClassTableKey() { return std::string(1, LetterOf(Family::kMeta)) + 'c'; }

std::string KeyAsHex(std::string_view key) {
  return absl::BytesToHexString(absl::string_view(key.data(), key.size()));
}

}  // namespace steadymap

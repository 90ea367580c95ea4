#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

namespace steadymap {

/// An integer that means one thing only; `Tag` keeps different ones from mixing.
template <typename Tag, typename Integer>
class StrongInteger {
 public:
  constexpr StrongInteger() = default;

  explicit constexpr StrongInteger(Integer value) : value_(value) {}

  constexpr Integer value() const { return value_; }

  /// The integer that follows.
  constexpr StrongInteger Next() const { return StrongInteger(static_cast<Integer>(value_ + 1)); }

  friend constexpr auto operator<=>(const StrongInteger&, const StrongInteger&) = default;

 private:
  Integer value_ = 0;
};

/// An object of a map; 0 is the background, which has no belief and no cuboid.
using ObjectId = StrongInteger<struct ObjectIdTag, std::uint64_t>;
inline constexpr ObjectId kBackgroundId{0};

/// A semantic class: an index into the map's class table.
using ClassId = StrongInteger<struct ClassIdTag, std::uint16_t>;

/// The number of an atomic commit of a map; 0 is the empty map before the first.
using Revision = StrongInteger<struct RevisionTag, std::uint64_t>;

/// The place of an entry, mostly a frame, in its map's log, gap-free from 1; 0 is "none yet".
using MapSequence = StrongInteger<struct MapSequenceTag, std::uint64_t>;

/// The place of a frame in its upload session, from 1; 0 is "none yet".
using ClientSequence = StrongInteger<struct ClientSequenceTag, std::uint64_t>;

/// The place of an event in its map's history, gap-free from 1; 0 is "none yet".
using EventNumber = StrongInteger<struct EventNumberTag, std::uint64_t>;

/// The store's key of a map. Never reused, so a map created anew under an old name shares nothing
/// with its predecessor.
using MapKey = StrongInteger<struct MapKeyTag, std::uint64_t>;

/// What takes frames: a sensor, by its id and that of the robot that carries it.
struct SensorName {
  std::string robot;
  std::string sensor;

  /// What a robot's only sensor is called where nobody says.
  static constexpr char kDefaultSensor[] = "camera";

  /// `robot/sensor`, for people.
  std::string ToString() const { return robot + "/" + sensor; }

  friend auto operator<=>(const SensorName&, const SensorName&) = default;
};

/// Whether `text` may be a tenant, map, robot, sensor or session id: `[a-z][a-z0-9-]{0,62}`.
bool IsValidId(std::string_view text);

/// The name of a map on the wire: `tenants/{tenant}/maps/{map}`.
struct MapName {
  std::string tenant;
  std::string map;

  /// Errors: `InvalidArgument` with reason `BAD_NAME` and the field `name`.
  static absl::StatusOr<MapName> Parse(std::string_view name);

  std::string ToString() const;

  friend auto operator<=>(const MapName&, const MapName&) = default;
};

}  // namespace steadymap

template <typename Tag, typename Integer>
struct std::hash<steadymap::StrongInteger<Tag, Integer>> {
  std::size_t operator()(const steadymap::StrongInteger<Tag, Integer>& id) const noexcept {
    return std::hash<Integer>()(id.value());
  }
};

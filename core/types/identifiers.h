#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

namespace steadymap {

/// An integer type for one kind of number. `Tag` prevents the mixing of different kinds.
template <typename Tag, typename Integer>
class StrongInteger {
 public:
  constexpr StrongInteger() = default;

  explicit constexpr StrongInteger(Integer value) : value_(value) {}

  constexpr Integer value() const { return value_; }

  /// Returns the successor.
  constexpr StrongInteger Next() const { return StrongInteger(static_cast<Integer>(value_ + 1)); }

  friend constexpr auto operator<=>(const StrongInteger&, const StrongInteger&) = default;

 private:
  Integer value_ = 0;
};

/// The id of an object of a map. 0 is the background, which has no belief and no cuboid.
using ObjectId = StrongInteger<struct ObjectIdTag, std::uint64_t>;
inline constexpr ObjectId kBackgroundId{0};

/// The id of a semantic class, a key of the map's class table.
using ClassId = StrongInteger<struct ClassIdTag, std::uint16_t>;

/// The class of surface without label, and of objects that were found without labels.
inline constexpr ClassId kNoClass{0};

/// The number of a map state: the map sequence of its newest entry. 0 is the empty map.
using Revision = StrongInteger<struct RevisionTag, std::uint64_t>;

/// The number of an entry (a frame, or added classes) of a map's log, from 1 without gaps; 0 is
/// "none yet".
using MapSequence = StrongInteger<struct MapSequenceTag, std::uint64_t>;

/// The number of a frame in its upload session, from 1; 0 is "none yet".
using ClientSequence = StrongInteger<struct ClientSequenceTag, std::uint64_t>;

/// The number of an event in its map's history, from 1 without gaps; 0 is "none yet".
using EventNumber = StrongInteger<struct EventNumberTag, std::uint64_t>;

/// The store's key of a map. Never reused, so a map created under the name of a deleted map shares
/// no data with it.
using MapKey = StrongInteger<struct MapKeyTag, std::uint64_t>;

/// The source of frames: the id of a sensor and of the robot that carries it.
struct SensorName {
  std::string robot;
  std::string sensor;

  /// The id of a robot's sensor if the client gives none.
  static constexpr char kDefaultSensor[] = "camera";

  /// Returns `robot/sensor`, for display.
  std::string ToString() const { return robot + "/" + sensor; }

  friend auto operator<=>(const SensorName&, const SensorName&) = default;
};

/// True if `text` is a valid tenant, map, robot, sensor or session id: `[a-z][a-z0-9-]{0,62}`.
bool IsValidId(std::string_view text);

/// The name of a map on the wire: `tenants/{tenant}/maps/{map}`.
struct MapName {
  std::string tenant;
  std::string map;

  /// Parses a map name. Errors: `InvalidArgument` with reason `BAD_NAME` and the field `name`.
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

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "core/types/identifiers.h"
#include "core/types/timestamp.h"

namespace steadymap {

struct ObjectState;
struct MapSnapshot;

/// Number of sessions that find an object gone, against another sensor, until it is a
/// contradiction.
inline constexpr std::uint32_t kConfirmingSessions = 2;

/// What one sensor has found against another one: the object was gone shortly after the other had
/// seen it. Once, the object may have changed; more than once, the two contradict each other.
struct Contradiction {
  SensorName absent;           ///< Found the object gone.
  SensorName present;          ///< Had seen it, the last time before.
  Timestamp since;             ///< Capture time of the first look that found it gone.
  Timestamp last;              ///< Capture time of the last such look.
  std::uint32_t sessions = 0;  ///< Number of sessions that found it gone.

  /// True if a change does not explain it: the object left, came back, and left again.
  bool is_confirmed() const { return sessions >= kConfirmingSessions; }

  friend bool operator==(const Contradiction&, const Contradiction&) = default;
};

/// Largest number of contradictions of an object; of more, the one with the oldest last look is
/// dropped.
inline constexpr std::size_t kMaxContradictions = 8;

/// Takes in that a session of `source` found a known object gone at `time`, its last look. Returns
/// the contradiction to the sensor that saw the object last, valid until the next change; null if
/// that was `source` itself, which ends all contradictions, or longer ago than `window_s`, seconds.
const Contradiction* ReportAbsence(const SensorName& source,
                                   Timestamp time,
                                   double window_s,
                                   ObjectState* object);

/// Takes in that a session of `source` saw the object in its place, the last time at `time`. Ends
/// its contradiction unless it found the object gone since.
void ReportPresence(const SensorName& source, Timestamp time, ObjectState* object);

/// Objects about which two sensors contradict each other.
struct SensorContradiction {
  SensorName other;
  std::uint32_t objects = 0;  ///< Number of present objects.
  Timestamp since;            ///< Of the first of them.
};

/// Returns with which other sensors each sensor of a map disagrees, by increasing name. Cost:
/// proportional to the number of objects.
std::map<SensorName, std::vector<SensorContradiction>> FindContradictions(const MapSnapshot& map);

}  // namespace steadymap
